#include <fmt/format.h>

#include "commands.h"
#include "cpplus/pipeline/info_command.h"

namespace cpplus {

void add_info_command(CommandLine* command_line) {
  const auto paths = std::make_shared<std::vector<std::string>>();
  const auto run = [paths] {
    for (const std::string& path : *paths) {
      for (const std::string& line : describe_path(path)) fmt::print("{}\n", line);
    }
  };
  CLI::App* info = command_line->add_command("info", "Says what files and folders are: counts, extents, models", run);
  info->add_option("PATH", *paths, "Point cloud, COLMAP model, trajectory, stamps, image, or a folder of these")
      ->required()
      ->type_name("");
}

}  // namespace cpplus
