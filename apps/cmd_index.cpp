#include <fmt/format.h>

#include <memory>

#include "commands.h"
#include "cpplus/core/log.h"
#include "cpplus/pipeline/index_command.h"

namespace cpplus {

void add_index_command(CommandLine* command_line) {
  const auto maps = std::make_shared<std::vector<std::string>>();
  CLI::App* index = command_line->add_command<IndexCommandOptions>(
      "index", "Sorts maps that may be larger than memory into a file that other commands take for --map",
      [maps](const IndexCommandOptions& options) {
        const IndexSummary summary = index_command(*maps, options);
        if (summary.was_sorted) log_info("went on from the points that a run before had sorted");
        log_info(fmt::format("{}: {} points ({} dropped as not finite) in {} roots, sorted in {} parts", options.out,
                             summary.num_points, summary.num_dropped_non_finite, summary.num_roots,
                             summary.num_buckets));
      });
  index->add_option("MAP", *maps, "Point clouds (.pcd .ply .las) of one frame, as one map")->required()->type_name("");
}

}  // namespace cpplus
