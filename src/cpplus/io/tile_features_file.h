#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cpplus/cloud/tile_features.h"

namespace cpplus {

/// Goes up with every change of the file, or of what is found in a map for the same options.
inline constexpr uint32_t kTileFeaturesVersion = 1;

/// Writes the features of a tile, whole or not at all. `key`: one line that says what they were found in and how.
/// Throws Error naming the path where it cannot be written.
void write_tile_features(const std::string& path, const std::string& key, const TileFeatures& features);

/// Reads them; nothing where there is no such file, or one of another version, or whose key is another. Throws Error
/// naming the path where the file cannot be read or is damaged (docs/index.md).
std::optional<TileFeatures> read_tile_features(const std::string& path, const std::string& key);

}  // namespace cpplus
