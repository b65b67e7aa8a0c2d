#include <fmt/format.h>

#include "commands.h"
#include "cpplus/core/log.h"
#include "cpplus/pipeline/colorize_command.h"

namespace cpplus {

void add_colorize_command(CommandLine* command_line) {
  command_line->add_command<ColorizeCommandOptions>(
      "colorize", "Colours a map from images with poses", [](const ColorizeCommandOptions& options) {
        const ColorizeSummary summary = run_colorize(options);
        log_info(fmt::format("{}: {} of {} points coloured ({:.1f} %) from {} images, {} images skipped", options.out,
                             summary.num_colored, summary.num_points,
                             100.0 * static_cast<double>(summary.num_colored) / static_cast<double>(summary.num_points),
                             summary.num_images, summary.num_skipped));
        if (summary.num_held_out == 0) return;
        log_info(fmt::format(
            "{} held-out images foretold: PSNR {:.2f} dB ({:.2f} dB with matched exposure) over {:.0f} "
            "% of their pixels",
            summary.num_held_out, psnr_db(summary.held_out.mean_square), psnr_db(summary.held_out.matched_mean_square),
            100.0 * static_cast<double>(summary.held_out.num_covered) /
                static_cast<double>(summary.held_out.num_pixels)));
      });
}

}  // namespace cpplus
