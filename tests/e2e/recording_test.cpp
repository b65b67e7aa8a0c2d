// From a recording to the coloured map: a ROS 1 bag made by Debian's rosbag from a simulated walk, through import and
// run.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/simulate/path.h"
#include "cpplus/simulate/simulate.h"
#include "run_cpplus.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kBegin = 1000.0;       // of the recording, seconds: what the simulation calls 0
constexpr double kTimeOffset = 0.015;   // the camera's clock is so much behind the LiDAR's, seconds
constexpr double kOdometryStep = 0.05;  // seconds
constexpr int kMissingPackages = 3;     // exit code of make_bag.py

/// A room that a body with a LiDAR and a camera walks through. The odometry has a pose for each 50 ms of the body, on
/// which the LiDAR stands crosswise; /tf_static knows the camera only roughly.
class Recording {
 public:
  explicit Recording(const std::string& directory) : directory_(directory) {
    SimulateOptions options;
    options.seed = 5;
    options.width = 384;
    options.height = 288;
    options.images = 10;
    options.blurred = 0;
    options.scans = 20;
    options.scan_pose_sigma_m = 0.0;
    options.scan_pose_sigma_deg = 0.0;
    world = simulate_world(options);
  }

  SimulatedWorld world;

  ProcessResult make_bag(const std::string& bag, const std::string& kind) const {
    fs::create_directories(directory_ + "/parts");
    write_file(directory_ + "/parts/recording.json", description().dump());
    return run_program(CPPLUS_DEBIAN_PYTHON3, {CPPLUS_MAKE_BAG, directory_ + "/parts", bag, kind});
  }

  /// The colour of a point in the images whose true pose sees it, mean over them; nothing where none does.
  std::optional<Eigen::Vector3d> true_color(const Eigen::Vector3d& x_in_map) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (const SimulatedImage& image : world.images) {
      const Eigen::Vector3d x_in_camera = image.camera_from_map * x_in_map;
      const auto pixel = world.camera.project(x_in_camera);
      if (!pixel || !world.camera.in_image(*pixel)) continue;
      const int x = static_cast<int>(std::lround(pixel->x()));
      const int y = static_cast<int>(std::lround(pixel->y()));
      const int column = std::min(x / 4, image.range.width - 1);
      const int row = std::min(y / 4, image.range.height - 1);
      if (std::abs(image.range.at(column, row) - x_in_camera.norm()) > 0.1) continue;
      for (int c = 0; c < 3; ++c) sum[c] += image.pixels.at(x, y)[static_cast<size_t>(c)];
      ++count;
    }
    return count > 0 ? std::optional<Eigen::Vector3d>(sum / count) : std::nullopt;
  }

 private:
  static json numbers(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
  static json numbers(const Eigen::Quaterniond& q) { return {q.x(), q.y(), q.z(), q.w()}; }

  static json transform(const std::string& parent, const std::string& child, const Rigid3& parent_from_child) {
    return {{"parent", parent},
            {"child", child},
            {"translation", numbers(parent_from_child.translation)},
            {"rotation", numbers(parent_from_child.rotation)}};
  }

  json description() const {
    const Rigid3 body_from_lidar(Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ())),
                                 {0.1, 0.05, 0.3});
    const Eigen::Vector3d wrong_turn(0.008, -0.006, 0.004);  // 0.6 degrees
    const Rigid3 wrong(Eigen::Quaterniond(so3_exp(wrong_turn)), {0.03, -0.02, 0.02});
    json parts;
    parts["camera"] = camera();
    parts["transforms"] = {transform("body", "lidar", body_from_lidar),
                           transform("lidar", "camera", world.lidar_from_camera * wrong)};
    const Path path(world.scene.way);
    for (double t = 0.0; t < path.duration_s(); t += kOdometryStep) {
      const Rigid3 map_from_body = path.map_from_lidar(t) * inverse(body_from_lidar);
      parts["poses"].push_back({{"stamp", kBegin + t},
                                {"translation", numbers(map_from_body.translation)},
                                {"rotation", numbers(map_from_body.rotation)}});
    }
    for (const SimulatedScan& scan : world.scans) parts["scans"].push_back(write_scan(scan));
    for (const SimulatedImage& image : world.images) parts["images"].push_back(write_image(image));
    return parts;
  }

  json camera() const {
    const std::vector<double> p = world.camera.params();  // OPENCV: fx fy cx cy k1 k2 p1 p2
    return {{"width", world.camera.width()},
            {"height", world.camera.height()},
            {"k", {p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1}},
            {"d", {p[4], p[5], p[6], p[7], 0}}};
  }

  json write_scan(const SimulatedScan& scan) const {
    std::string bytes;
    for (size_t i = 0; i < scan.scan.points.size(); ++i) {
      const Eigen::Vector3f point = scan.scan.points.point(i).cast<float>();
      const std::array<float, 4> values = {point.x(), point.y(), point.z(), scan.scan.points.intensities[i]};
      bytes.append(reinterpret_cast<const char*>(values.data()), sizeof(values));
    }
    const std::string name = fmt::format("{}.bin", scan.stamp_s);
    write_file(directory_ + "/parts/" + name, bytes);
    return {{"stamp", kBegin + scan.stamp_s}, {"file", name}};
  }

  json write_image(const SimulatedImage& image) const {
    const std::string stem = image.name.substr(0, image.name.find('.'));
    const ColorImage& pixels = image.pixels;
    std::string ppm = fmt::format("P6\n{} {}\n255\n", pixels.width, pixels.height);
    ppm.append(reinterpret_cast<const char*>(pixels.pixels.data()), 3 * pixels.pixels.size());
    write_file(directory_ + "/parts/" + stem + ".ppm", ppm);
    write_png(directory_ + "/parts/" + stem + ".png", pixels);
    return {{"stamp", kBegin + image.stamp_s - kTimeOffset}, {"ppm", stem + ".ppm"}, {"png", stem + ".png"}};
  }

  std::string directory_;
};

struct PoseErrors {
  double rms_deg = 0.0;
  double rms_m = 0.0;
};

/// Images are named by their stamps, so they come in the order of the world's.
PoseErrors errors_of(const std::string& model_path, const SimulatedWorld& world) {
  SparseModel model = read_sparse_model(model_path);
  std::sort(model.images.begin(), model.images.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  EXPECT_EQ(model.images.size(), world.images.size());
  PoseErrors errors;
  for (size_t i = 0; i < std::min(model.images.size(), world.images.size()); ++i) {
    const Rigid3& estimate = model.images[i].camera_from_map;
    const Rigid3& truth = world.images[i].camera_from_map;
    errors.rms_deg += std::pow(rotation_angle_between(estimate, truth) * 180.0 / M_PI, 2);
    errors.rms_m += (camera_center(estimate) - camera_center(truth)).squaredNorm();
  }
  const auto count = static_cast<double>(world.images.size());
  return {std::sqrt(errors.rms_deg / count), std::sqrt(errors.rms_m / count)};
}

void expect_right_colors(const std::string& coloured_map, const Recording& recording) {
  const PointCloud map = read_point_cloud(coloured_map);
  std::vector<double> differences;
  size_t num_coloured = 0;
  for (size_t i = 0; i < map.size(); ++i) {
    if (map.num_views[i] == 0) continue;
    ++num_coloured;
    const auto truth = recording.true_color(map.point(i));
    if (!truth) continue;
    const Eigen::Vector3d color(map.colors[i][0], map.colors[i][1], map.colors[i][2]);
    differences.push_back((color - *truth).cwiseAbs().maxCoeff());
  }
  EXPECT_GT(map.size(), 100000u);
  EXPECT_GT(2 * num_coloured, map.size());
  ASSERT_GT(2 * differences.size(), num_coloured);
  const auto quantile = [&](double share) {
    const auto at = differences.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(differences.size()));
    std::nth_element(differences.begin(), at, differences.end());
    return *at;
  };
  testing::Test::RecordProperty("median_grey_levels", std::to_string(quantile(0.5)));
  testing::Test::RecordProperty("p90_grey_levels", std::to_string(quantile(0.9)));
  EXPECT_LT(quantile(0.5), 8.0);
  EXPECT_LT(quantile(0.9), 40.0);
}

TEST(Recording, ABagBecomesAColouredMapByImportAndRun) {
  const std::string directory = make_test_directory();
  const Recording recording(directory);
  const std::string bag = directory + "/walk.bag";
  const std::string project = directory + "/project";
  const ProcessResult made = recording.make_bag(bag, "raw");
  if (made.exit_code == kMissingPackages) GTEST_SKIP() << "scripts/setup installs what is missing: " << made.err;
  ASSERT_EQ(made.exit_code, 0) << made.err;

  const ProcessResult imported = run_cpplus({"import", "rosbag", bag, "--out", project});
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  EXPECT_EQ(imported.err, "");
  const ProcessResult ran = run_cpplus({"run", "--config", project + "/project.yaml"});
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_EQ(ran.err, "");

  const PoseErrors before = errors_of(project + "/coarse", recording.world);
  const PoseErrors after = errors_of(project + "/refined/sparse", recording.world);
  for (const auto& [name, value] : {std::pair("before_deg", before.rms_deg), std::pair("before_mm", 1e3 * before.rms_m),
                                    std::pair("after_deg", after.rms_deg), std::pair("after_mm", 1e3 * after.rms_m)}) {
    RecordProperty(name, std::to_string(value));
  }
  EXPECT_GT(before.rms_deg, 0.5);
  EXPECT_LT(after.rms_deg, 0.7 * before.rms_deg);
  EXPECT_LT(after.rms_m, 0.7 * before.rms_m);
  expect_right_colors(project + "/coloured.ply", recording);
}

TEST(Recording, CompressedImagesAndChunksGiveTheSameProject) {
  const std::string directory = make_test_directory();
  const Recording recording(directory);
  for (const char* kind : {"raw", "compressed"}) {
    const std::string bag = fmt::format("{}/{}.bag", directory, kind);
    const ProcessResult made = recording.make_bag(bag, kind);
    if (made.exit_code == kMissingPackages) GTEST_SKIP() << "scripts/setup installs what is missing: " << made.err;
    ASSERT_EQ(made.exit_code, 0) << made.err;
    const ProcessResult imported = run_cpplus({"import", "rosbag", bag, "--out", directory + "/" + kind});
    ASSERT_EQ(imported.exit_code, 0) << imported.err;
  }
  size_t num_files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(directory + "/raw")) {
    if (!entry.is_regular_file()) continue;
    ++num_files;
    const std::string name = fs::relative(entry.path(), directory + "/raw").generic_string();
    const std::string other = directory + "/compressed/" + name;
    if (name.starts_with("images/")) {
      EXPECT_TRUE(read_color_image(entry.path().string()).pixels == read_color_image(other).pixels) << name;
    } else if (name != "project.yaml") {
      EXPECT_TRUE(read_file(entry.path().string()) == read_file(other)) << name;
    }
  }
  EXPECT_EQ(num_files, recording.world.images.size() + recording.world.scans.size() + 5);
}

}  // namespace
}  // namespace cpplus
