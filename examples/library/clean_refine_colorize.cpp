// Scans and coarse camera poses -> static map, refined poses, coloured map, as another program would do it.
// usage: clean_refine_colorize PROJECT OUT     PROJECT holds scans/ with poses.txt, images/, coarse/ (a COLMAP model)
#include <cstdio>
#include <string>

#include "cpplus/core/error.h"
#include "cpplus/pipeline/clean_command.h"
#include "cpplus/pipeline/colorize_command.h"
#include "cpplus/pipeline/refine_command.h"

int main(int argc, char** argv) try {
  if (argc != 3) return 2;
  const std::string project = argv[1], out = argv[2];

  cpplus::CleanCommandOptions clean;  // every option has its default
  clean.scans = project + "/scans";
  clean.poses = project + "/scans/poses.txt";
  clean.out = out + "/map.ply";
  const cpplus::CleanSummary cleaned = cpplus::run_clean(clean);

  cpplus::RefineCommandOptions refine;
  refine.map = clean.out;
  refine.images = project + "/images";
  refine.poses = project + "/coarse";
  refine.out = out + "/refined";
  const cpplus::RefineSummary refined = cpplus::refine_command(refine);

  cpplus::ColorizeCommandOptions colorize;
  colorize.map = clean.out;
  colorize.images = refine.images;
  colorize.poses = refine.out + "/sparse";
  colorize.out = out + "/coloured.ply";
  const cpplus::ColorizeSummary colored = cpplus::run_colorize(colorize);

  std::printf("%zu of %zu points dynamic, %zu of %zu images refined, %zu points coloured\n", cleaned.num_dynamic,
              cleaned.num_points, refined.num_refined, refined.num_images, colored.num_colored);
} catch (const cpplus::Error& error) {  // one line that names the file and what is wrong with it
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
