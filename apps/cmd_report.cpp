#include <fmt/format.h>

#include <memory>

#include "commands.h"
#include "cpplus/core/log.h"
#include "cpplus/pipeline/report_command.h"

namespace cpplus {

void add_report_command(CommandLine* command_line) {
  const auto folder = std::make_shared<std::string>();
  CLI::App* report = command_line->add_command<ReportCommandOptions>(
      "report", "Makes a page about a result of refine, to be opened in a browser from disk",
      [folder](const ReportCommandOptions& options) {
        const ReportSummary summary = report_command(*folder, options);
        log_info(fmt::format("{}: {} images, {} pictures made, {} kept", summary.page, summary.num_images,
                             summary.num_pictures_made, summary.num_pictures_kept));
      });
  report->add_option("DIR", *folder, "Folder that refine wrote, or the folder of a run that holds it")
      ->required()
      ->type_name("");
}

}  // namespace cpplus
