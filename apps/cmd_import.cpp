#include <fmt/format.h>

#include "commands.h"
#include "cpplus/core/log.h"
#include "cpplus/pipeline/import_command.h"

namespace cpplus {

void add_import_command(CommandLine* command_line) {
  const auto positional = std::make_shared<std::pair<std::string, std::string>>();
  const auto run = [positional](const ImportCommandOptions& options) {
    ImportCommandOptions given = options;
    if (!positional->first.empty()) given.format = positional->first;
    if (!positional->second.empty()) given.source = positional->second;
    const ImportSummary summary = import_command(given);
    log_info(fmt::format("{}: {} map, {} images ({} with a pose, {} stamps), trajectory of {} poses, {} scans",
                         given.out, summary.has_map ? "a" : "no", summary.num_images, summary.num_posed,
                         summary.num_stamps, summary.num_trajectory_poses, summary.num_scans));
  };
  CLI::App* command = command_line->add_command<ImportCommandOptions>(
      "import", "Brings another program's output into a project folder in our conventions", run);
  command
      ->add_option("FORMAT", positional->first,
                   "colmap, nerfstudio, kitti, kitti-raw, fast-livo2, global-lvba, lio-sam, r3live, rosbag")
      ->type_name("");
  command->add_option("SRC", positional->second, "Folder, nerfstudio's transforms.json, or a bag")->type_name("");
}

}  // namespace cpplus
