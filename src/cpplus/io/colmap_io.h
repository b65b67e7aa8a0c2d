#pragma once

#include <string>

#include "cpplus/geometry/sparse_model.h"

namespace cpplus {

/// Reads a COLMAP model folder, binary (cameras.bin, images.bin) or else text (cameras.txt, images.txt), binary first
/// where it holds both, as COLMAP does. points3D may be missing; rigs and frames are ignored.
///
/// COLMAP's world frame is our map frame. Its pixel convention (centre of the top-left pixel = (0.5, 0.5)) is turned
/// into ours here: 0.5 is taken off principal points and observations. Observations without a 3D point are left out.
/// Quaternions up to 1 % off unit length are normalised.
///
/// Throws Error naming file, line or record, and value: missing or truncated file, unknown camera model, bad focal
/// length, image of a missing camera, bad quaternion, not a number, an id or image name that occurs twice, a track
/// that names a missing image or observation.
SparseModel read_sparse_model(const std::string& directory);

/// Writes cameras.txt, images.txt and points3D.txt, numbers with as many digits as bring back the same double. All
/// three are written before any appears under its name. Throws Error where the folder holds a binary model, which
/// readers would take instead.
void write_sparse_model_text(const std::string& directory, const SparseModel& model);

/// Writes cameras.bin, images.bin and points3D.bin.
void write_sparse_model_binary(const std::string& directory, const SparseModel& model);

}  // namespace cpplus
