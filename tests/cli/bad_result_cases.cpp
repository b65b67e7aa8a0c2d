// Results of `refine` that `report` and `view` cannot show, or not wholly.
#include <filesystem>

#include "bad_input_cases.h"
#include "run_cpplus.h"

namespace cpplus {

namespace {

using Arguments = std::vector<std::string>;
using Cases = std::map<std::string, BadInputCase>;

constexpr const char* kEmptyMap =
    "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 0\nHEIGHT 1\nPOINTS 0\nDATA ascii\n";

/// A case that refines into DIR/result, spoils something, and then runs `report` or `view` on it.
BadInputCase on_result(const std::string& command, const std::function<void(const TinyScene&)>& spoil,
                       const Arguments& more = {}) {
  return [=](const TinyScene& scene) {
    run_cpplus(with_flag(scene.refine(), "--out", scene.path("result")));
    spoil(scene);
    Arguments arguments = {command, scene.path("result")};
    for (const std::string& argument : more) {
      arguments.push_back(argument.starts_with("DIR/") ? scene.path(argument.substr(4)) : argument);
    }
    return arguments;
  };
}

BadInputCase on_good_result(const std::string& command, const Arguments& more) {
  return on_result(
      command, [](const TinyScene&) {}, more);
}

void spoil_image(const TinyScene& scene) { scene.write("images/b.png", "no image"); }

Cases report_cases() {
  return {
      {"result that does not exist",
       [](const TinyScene& scene) {
         return Arguments{"report", scene.path("none")};
       }},
      {"folder without a result",
       [](const TinyScene& scene) {
         return Arguments{"report", scene.path("images")};
       }},
      {"folder of two results", on_result("report",
                                          [](const TinyScene& scene) {
                                            for (const char* name : {"result/a", "result/b"}) {
                                              std::filesystem::create_directory(scene.path(name));
                                              std::filesystem::copy(scene.path("result/report.json"), scene.path(name));
                                            }
                                            std::filesystem::remove(scene.path("result/report.json"));
                                          })},
      {"result that is not JSON",
       on_result("report", [](const TinyScene& scene) { scene.write("result/report.json", "{\"inputs\": "); })},
      {"result of another program",
       on_result("report", [](const TinyScene& scene) { scene.write("result/report.json", "{\"inputs\": {}}"); })},
      {"result that does not say what it was made of",
       on_result("report", [](const TinyScene& scene) { scene.write("result/report.json", "{}"); })},
      {"result whose images have no names",
       on_result("report",
                 [](const TinyScene& scene) {
                   scene.write("result/report.json",
                               "{\"options\": {}, \"images\": [{}], \"inputs\": {\"map\": \"\", "
                               "\"images\": \"\", \"poses\": \"\"}}");
                 })},
      {"result without refined poses",
       on_result("report", [](const TinyScene& scene) { std::filesystem::remove_all(scene.path("result/sparse")); })},
      {"map of a result that has moved",
       on_result("report", [](const TinyScene& scene) { std::filesystem::remove(scene.path("map.pcd")); })},
      {"coarse poses of a result that have moved",
       on_result("report", [](const TinyScene& scene) { std::filesystem::remove_all(scene.path("model")); })},
      {"photo of a result that is corrupt", on_result("report", spoil_image)},
      {"size of pictures out of range", on_good_result("report", {"--picture-size-px", "10"})},
      {"report below a file", on_good_result("report", {"--out", "DIR/map.pcd/out"})},
  };
}

Cases view_cases() {
  return {
      {"viewer of a folder without a result",
       [](const TinyScene& scene) {
         return Arguments{"view", scene.path("images"), "--export", scene.path("out")};
       }},
      {"cloud to view that does not exist", on_good_result("view", {"--cloud", "DIR/none.ply", "--export", "DIR/out"})},
      {"cloud to view of unknown extension",
       on_good_result("view", {"--cloud", "DIR/stamps.txt", "--export", "DIR/out"})},
      {"cloud to view without points",
       on_result("view", [](const TinyScene& scene) { scene.write("empty.pcd", kEmptyMap); },
                 {"--cloud", "DIR/empty.pcd", "--export", "DIR/out"})},
      {"viewer of a cloud without colours", on_good_result("view", {"--export", "DIR/out"})},
      {"photo to view that is corrupt", on_result("view", spoil_image, {"--export", "DIR/out"})},
      {"viewer below a file", on_good_result("view", {"--export", "DIR/map.pcd/out"})},
      {"port of the viewer out of range", on_good_result("view", {"--port", "70000"})},
      {"size of photos out of range", on_good_result("view", {"--photo-size-px", "10"})},
  };
}

}  // namespace

Cases bad_result_cases() {
  Cases all = report_cases();
  all.merge(view_cases());
  return all;
}

}  // namespace cpplus
