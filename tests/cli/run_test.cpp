// `cpplus run`: the steps of a configuration, one after the other, each once.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>

#include "run_cpplus.h"
#include "tiny_scene.h"

namespace cpplus {
namespace {

using testing::HasSubstr;

/// Poses from the trajectory, then colours.
std::vector<std::string> run_of(const TinyScene& scene) {
  scene.write("project.yaml",
              "poses:\n  trajectory: " + scene.path("trajectory.txt") + "\n  rig: " + scene.path("rig.yaml") +
                  "\n  images: " + scene.path("images") + "\n  stamps: " + scene.path("stamps.txt") +
                  "\n  max_gap_s: 1.5\n  out: " + scene.path("coarse") +
                  "\ncolorize:\n  map: " + scene.path("map.pcd") + "\n  images: " + scene.path("images") +
                  "\n  poses: " + scene.path("coarse") + "\n  out: " + scene.path("out.ply") + "\n");
  return {"run", "--config", scene.path("project.yaml")};
}

/// A rig whose camera looks along the LiDAR's z axis, at the wall.
TinyScene scene_for_run() {
  TinyScene scene(make_test_directory());
  scene.replace("rig.yaml", "[0.5, 0.5, -0.5, 0.5]", "[1, 0, 0, 0]");
  return scene;
}

TEST(Run, StepsAreDoneInOrderAndOnce) {
  const TinyScene scene = scene_for_run();
  const ProcessResult first = run_cpplus(run_of(scene));
  EXPECT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, HasSubstr("poses: done"));
  EXPECT_THAT(first.out, HasSubstr("colorize: done"));
  EXPECT_TRUE(std::filesystem::exists(scene.path("out.ply")));
  const ProcessResult second = run_cpplus(run_of(scene));
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_THAT(second.out, HasSubstr("poses: up to date\ncolorize: up to date\n"));
  scene.replace("stamps.txt", "b.png 10.5", "b.png 10.25");
  const ProcessResult third = run_cpplus(run_of(scene));
  EXPECT_THAT(third.out, HasSubstr("poses: done"));
  EXPECT_THAT(third.out, HasSubstr("colorize: done"));
}

TEST(Run, AFailedStepEndsTheRunAndIsTriedAgain) {
  const TinyScene scene = scene_for_run();
  const std::vector<std::string> arguments = run_of(scene);
  const std::string map = scene.read("map.pcd");
  scene.write("map.pcd", "");
  const ProcessResult failed = run_cpplus(arguments);
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_THAT(failed.err, HasSubstr("map.pcd: not a PCD file"));
  scene.write("map.pcd", map);
  const ProcessResult resumed = run_cpplus(arguments);
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_THAT(resumed.out, HasSubstr("poses: up to date\n"));
  EXPECT_THAT(resumed.out, HasSubstr("colorize: done"));
}

/// What ran of a run's steps: "poses colorize".
std::string steps_done(const std::vector<std::string>& arguments) {
  const ProcessResult result = run_cpplus(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  std::string done;
  for (const std::string& line : lines_of(result.out)) {
    const size_t end = line.find(": done");
    if (end == std::string::npos) continue;
    if (!done.empty()) done += ' ';
    done += line.substr(0, end);
  }
  return done;
}

TEST(Run, AChangeRunsTheStepsThatItConcerns) {
  const TinyScene scene = scene_for_run();
  scene.write(
      "project.yaml",
      fmt::format("clean: {{scans: {0}/scans, poses: {0}/scans/poses.txt, labels: {0}/labels, out: {0}/clean.pcd}}\n"
                  "poses: {{trajectory: {0}/trajectory.txt, rig: {0}/rig.yaml, images: {0}/images,\n"
                  "        stamps: {0}/stamps.txt, max_gap_s: 1.5, out: {0}/coarse}}\n"
                  "refine: {{map: {0}/clean.pcd, images: {0}/images, poses: {0}/coarse, out: {0}/refined}}\n"
                  "colorize: {{map: {0}/clean.pcd, images: {0}/images, poses: {0}/refined/sparse,\n"
                  "           out: {0}/out.ply}}\n",
                  scene.directory()));
  const std::vector<std::string> run = {"run", "--config", scene.path("project.yaml")};
  EXPECT_EQ(steps_done(run), "clean poses refine colorize");
  EXPECT_EQ(steps_done(run), "");
  scene.write("scans/0.pcd", scene.read("scans/0.pcd") + "\n");
  EXPECT_EQ(steps_done(run), "clean refine colorize");
  scene.replace("stamps.txt", "b.png 10.5", "b.png 10.25");
  EXPECT_EQ(steps_done(run), "poses refine colorize");
  scene.replace("project.yaml", "max_gap_s: 1.5", "max_gap_s: 1.25");
  EXPECT_EQ(steps_done(run), "poses refine colorize");
  scene.replace("project.yaml", "refine: {", "refine: {joint: false, ");
  EXPECT_EQ(steps_done(run), "refine colorize");
  const std::string done = "project.yaml.state/colorize.done";
  scene.write(done, scene.read(done).replace(0, scene.read(done).find('\n'), "version: 0.0.0"));
  EXPECT_EQ(steps_done(run), "colorize") << "another version of the program made it";
  EXPECT_EQ(steps_done(run), "");
}

}  // namespace
}  // namespace cpplus
