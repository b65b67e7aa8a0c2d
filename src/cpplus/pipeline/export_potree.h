#pragma once

#include <filesystem>

#include "cpplus/pipeline/export_command.h"

namespace cpplus {

/// The format potree of `cpplus export`: the points of the map in levels of detail, in `folder`. `origin` (metres, map
/// frame) becomes the origin of what is written.
ExportSummary export_potree(const ExportCommandOptions& options, const Eigen::Vector3d& origin,
                            const std::filesystem::path& folder);

}  // namespace cpplus
