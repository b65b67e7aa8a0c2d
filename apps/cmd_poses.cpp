#include <fmt/format.h>

#include "commands.h"
#include "cpplus/core/log.h"
#include "cpplus/pipeline/poses_command.h"

namespace cpplus {
namespace {

void run_poses(const PosesCommandOptions& options) {
  const PosesSummary summary = poses_command(options);
  const size_t num_skipped = summary.num_images - summary.num_posed;
  log_info(
      fmt::format("{}: coarse poses of {} of {} images, {} skipped ({} outside the trajectory, {} in gaps, {} without "
                  "a stamp, {} with a double one, {} of no camera)",
                  options.out, summary.num_posed, summary.num_images, num_skipped, summary.num_outside,
                  summary.num_in_gap, summary.num_without_stamp, summary.num_double_stamp, summary.num_without_camera));
}

}  // namespace

void add_poses_command(CommandLine* command_line) {
  command_line->add_command<PosesCommandOptions>(
      "poses", "Coarse camera poses from a LiDAR/IMU trajectory and rough extrinsics", run_poses);
}

}  // namespace cpplus
