#include "cpplus/io/colmap_io.h"

#include <fmt/format.h>

#include <filesystem>

#include "cpplus/core/error.h"
#include "cpplus/io/colmap_model.h"

namespace cpplus {

SparseModel read_sparse_model(const std::string& directory) {
  const std::filesystem::path folder(directory);
  if (!std::filesystem::is_directory(folder)) throw Error(fmt::format("{}: no such folder", directory));
  const auto has = [&](const char* name) { return std::filesystem::exists(folder / name); };
  if (has("cameras.bin") && has("images.bin")) return read_sparse_model_binary(directory);
  if (has("cameras.txt") && has("images.txt")) return read_sparse_model_text(directory);
  throw Error(fmt::format("{}: not a COLMAP model: neither cameras.txt and images.txt nor cameras.bin and images.bin",
                          directory));
}

}  // namespace cpplus
