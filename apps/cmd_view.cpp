#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "commands.h"
#include "cpplus/pipeline/view_command.h"

namespace cpplus {

void add_view_command(CommandLine* command_line) {
  const auto folder = std::make_shared<std::string>();
  CLI::App* view = command_line->add_command<ViewCommandOptions>(
      "view", "Shows the coloured map and the photos in a browser", [folder](const ViewCommandOptions& options) {
        view_command(*folder, options, [](const std::string& address) {
          fmt::print("{}\n", address);
          std::fflush(stdout);
        });
      });
  view->add_option("DIR", *folder, "Folder that refine wrote, or the folder of a run that holds it")
      ->required()
      ->type_name("");
}

}  // namespace cpplus
