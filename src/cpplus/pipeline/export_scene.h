#pragma once

#include <filesystem>

#include "cpplus/geometry/sparse_model.h"
#include "cpplus/pipeline/export_command.h"

namespace cpplus {

// The formats of `cpplus export` that hold images or the map. Each writes into `folder` and takes the model as it was
// read; `origin` (metres, map frame) becomes the origin of what is written.

/// colmap-text and colmap-bin: the images as they are, with sampled points and their tracks.
ExportSummary export_colmap(const ExportCommandOptions& options, const SparseModel& model,
                            const Eigen::Vector3d& origin, const std::filesystem::path& folder);

/// undistorted (images/ and sparse/ as text) and 3dgs (images/ and sparse/0/ in binary, principal points centred).
ExportSummary export_undistorted(const ExportCommandOptions& options, const SparseModel& model,
                                 const Eigen::Vector3d& origin, const std::filesystem::path& folder);

/// nerfstudio: transforms.json, images/, depths/ and sparse.ply.
ExportSummary export_nerfstudio(const ExportCommandOptions& options, const SparseModel& model,
                                const Eigen::Vector3d& origin, const std::filesystem::path& folder);

/// depth and normals: one picture an image of the model, whose file need not be there.
ExportSummary export_surface_maps(const ExportCommandOptions& options, const SparseModel& model,
                                  const std::filesystem::path& folder);

}  // namespace cpplus
