#include <fmt/format.h>

#include "commands.h"
#include "cpplus/core/log.h"
#include "cpplus/pipeline/adjust_command.h"

namespace cpplus {
namespace {

std::string describe(const AdjustResult& result) {
  const ThicknessChange& thickness = result.thickness;
  const std::string walls =
      fmt::format("walls {:.1f} -> {:.1f} mm thick", 1e3 * thickness.before_m, 1e3 * thickness.after_m);
  switch (result.status) {
    case AdjustStatus::kAdjusted:
      return fmt::format("adjusted {} scans; {}", result.scans.size(), walls);
    case AdjustStatus::kKeptTooFewScans:
      return "kept the poses: fewer than three scans";
    case AdjustStatus::kKeptTooFewPatches:
      return "kept the poses: too few planes that several scans see";
    case AdjustStatus::kKeptNotThinner:
      return fmt::format("kept the poses: held-out points get no thinner; {}", walls);
  }
  return "";
}

}  // namespace

void add_adjust_command(CommandLine* command_line) {
  command_line->add_command<AdjustCommandOptions>(
      "adjust", "Adjusts the poses of scans so that walls get thin", [](const AdjustCommandOptions& options) {
        log_info(fmt::format("{}: {}", options.out, describe(run_adjust(options))));
      });
}

}  // namespace cpplus
