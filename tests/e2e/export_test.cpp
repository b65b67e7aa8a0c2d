// Exports of the simulated world (made once by the test e2e/simulate), against its exact depth and by COLMAP itself.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "cpplus/colorize/view_sampler.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/npz_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/trajectory_io.h"
#include "run_cpplus.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

std::string world(const std::string& name) { return std::string(CPPLUS_E2E_WORLD) + "/" + name; }

/// The poses that fit the map, which every export here is made with.
SparseModel input_model() { return read_sparse_model(world("truth/on_map")); }

/// Exports into directory/FORMAT and returns that folder.
std::string run_export(const std::string& format, const std::string& directory, const Arguments& more = {}) {
  const std::string out = directory + "/" + format;
  Arguments arguments = {"export",
                         "--format",
                         format,
                         "--map",
                         world("map.pcd"),
                         "--images",
                         world("images"),
                         "--poses",
                         world("truth/on_map"),
                         "--out",
                         out};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const ProcessResult result = run_cpplus(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  return out;
}

/// The exact ranges of an image at pixels (4 i + 1.5, 4 j + 1.5); 0 = nothing there.
struct TrueRanges {
  explicit TrueRanges(const std::string& image) {
    const auto arrays = read_npz(world("truth/depth/") + fs::path(image).stem().string() + ".npz");
    const NpyArray& range = arrays.at("range");
    height = static_cast<int>(range.shape.at(0));
    width = static_cast<int>(range.shape.at(1));
    values = range.values;
  }
  double at(int i, int j) const { return values[static_cast<size_t>(j * width + i)]; }

  /// Whether a point at a range and a pixel lies on the surface: at the range between the four samples around the
  /// pixel (1 / range is linear on planes), or at that of one of them, where they lie on different surfaces.
  bool agrees(const Eigen::Vector2d& pixel, double range_m, double tolerance_m) const {
    const double x = std::clamp((pixel.x() - 1.5) / 4.0, 0.0, width - 1.001);
    const double y = std::clamp((pixel.y() - 1.5) / 4.0, 0.0, height - 1.001);
    const int i = static_cast<int>(x);
    const int j = static_cast<int>(y);
    const double right = x - i;
    const double down = y - j;
    const double inverse = (1 - down) * ((1 - right) / at(i, j) + right / at(i + 1, j)) +
                           down * ((1 - right) / at(i, j + 1) + right / at(i + 1, j + 1));
    const auto is_near = [&](double sample_m) { return std::abs(sample_m - range_m) < tolerance_m; };
    return is_near(1.0 / inverse) || is_near(at(i, j)) || is_near(at(i + 1, j)) || is_near(at(i, j + 1)) ||
           is_near(at(i + 1, j + 1));
  }

  int width = 0;
  int height = 0;
  std::vector<double> values;
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::map<uint32_t, PosedImage> images_by_id(const SparseModel& model) {
  std::map<uint32_t, PosedImage> images;
  for (const PosedImage& image : model.images) images.emplace(image.id, image);
  return images;
}

void expect_same_poses(const SparseModel& a, const SparseModel& b) {
  ASSERT_EQ(a.images.size(), b.images.size());
  for (size_t i = 0; i < a.images.size(); ++i) {
    EXPECT_EQ(a.images[i].name, b.images[i].name);
    EXPECT_LT(rotation_angle_between(a.images[i].camera_from_map, b.images[i].camera_from_map), 1e-7);
    EXPECT_LT((camera_center(a.images[i].camera_from_map) - camera_center(b.images[i].camera_from_map)).norm(), 1e-9);
  }
}

/// Of the observations, the share whose point lies on the surface that the image truly shows there.
double share_visible(const SparseModel& model) {
  constexpr double kMaxErrorM = 0.08;
  std::map<uint32_t, TrueRanges> truth;
  for (const PosedImage& image : model.images) truth.emplace(image.id, TrueRanges(image.name));
  const auto images = images_by_id(model);
  size_t num_visible = 0;
  size_t num_all = 0;
  for (const SparsePoint& point : model.points) {
    for (const SparsePoint::Observation& observation : point.track) {
      const double range = (images.at(observation.image_id).camera_from_map * point.position).norm();
      num_visible += truth.at(observation.image_id).agrees(observation.pixel, range, kMaxErrorM) ? 1 : 0;
      ++num_all;
    }
  }
  EXPECT_GT(num_all, 10000u);
  return static_cast<double>(num_visible) / static_cast<double>(num_all);
}

TEST(Export, TracksAreProjectionsOfPointsThatTheImagesShow) {
  const SparseModel model = read_sparse_model(run_export("colmap-text", make_test_directory()));
  expect_same_poses(model, input_model());
  EXPECT_GE(share_visible(model), 0.95);

  const PointCloud map = read_point_cloud(world("map.pcd"));
  std::set<std::array<float, 3>> map_points;
  for (const Eigen::Vector3f& x : map.positions) map_points.insert({x.x(), x.y(), x.z()});
  const auto images = images_by_id(model);
  const Camera& camera = model.cameras.begin()->second;
  std::map<uint32_t, size_t> num_observations;
  for (const SparsePoint& point : model.points) {
    ASSERT_GE(point.track.size(), 2u);
    const Eigen::Vector3f x = point.position.cast<float>();
    EXPECT_EQ(map_points.count({x.x(), x.y(), x.z()}), 1u);
    for (const SparsePoint::Observation& observation : point.track) {
      const auto pixel = camera.project(images.at(observation.image_id).camera_from_map * point.position);
      ASSERT_TRUE(pixel);
      EXPECT_LT((*pixel - observation.pixel).norm(), 0.5);
      EXPECT_TRUE(camera.in_image(observation.pixel));
      ++num_observations[observation.image_id];
    }
  }
  for (const PosedImage& image : model.images) EXPECT_GE(num_observations[image.id], 500u) << image.name;
}

TEST(Export, PixelsInTheFileBeginAtOneHalf) {
  const std::string out = run_export("colmap-text", make_test_directory());
  const SparseModel model = read_sparse_model(out);
  // By hand, from the numbers in the file alone: the first observation of the first image.
  const std::vector<std::string> lines = lines_of(read_file(out + "/images.txt"));
  const auto first = std::find_if(lines.begin(), lines.end(), [](const auto& line) { return !line.starts_with("#"); });
  std::istringstream pose(*first);
  std::istringstream observations(*std::next(first));
  double id = 0, qw = 0, qx = 0, qy = 0, qz = 0, tx = 0, ty = 0, tz = 0, x = 0, y = 0;
  uint64_t point_id = 0;
  pose >> id >> qw >> qx >> qy >> qz >> tx >> ty >> tz;
  observations >> x >> y >> point_id;
  const Eigen::Vector3d in_camera =
      Eigen::Quaterniond(qw, qx, qy, qz) * model.points.at(point_id - 1).position + Eigen::Vector3d(tx, ty, tz);
  const Camera& camera = model.cameras.begin()->second;  // the half pixel taken off
  EXPECT_NEAR(x, camera.project(in_camera)->x() + 0.5, 1e-6);
  EXPECT_NEAR(y, camera.project(in_camera)->y() + 0.5, 1e-6);
}

TEST(Export, ColoursAreThoseOfTheImages) {
  const SparseModel model = read_sparse_model(run_export("colmap-bin", make_test_directory()));
  const PosedImage& image = model.images.front();
  const ColorImage pixels = read_color_image(world("images/" + image.name));
  std::vector<double> differences;
  for (const SparsePoint& point : model.points) {
    for (const SparsePoint::Observation& observation : point.track) {
      if (observation.image_id != image.id) continue;
      const Rgb& seen = pixels.at(static_cast<int>(std::lround(observation.pixel.x())),
                                  static_cast<int>(std::lround(observation.pixel.y())));
      differences.push_back(std::abs(int{seen[1]} - int{point.color[1]}));
    }
  }
  EXPECT_LT(median(differences), 12.0);  // exposure differs between images
}

TEST(Export, DensityAndCapAreKept) {
  const std::string directory = make_test_directory();
  const SparseModel fine = read_sparse_model(run_export("colmap-bin", directory));
  fs::remove_all(directory + "/colmap-bin");
  const SparseModel coarse = read_sparse_model(run_export("colmap-bin", directory, {"--point-voxel-m", "0.25"}));
  fs::remove_all(directory + "/colmap-bin");
  const SparseModel capped = read_sparse_model(run_export("colmap-bin", directory, {"--max-points", "1000"}));
  EXPECT_LT(coarse.points.size(), fine.points.size() / 4);
  EXPECT_EQ(capped.points.size(), 1000u);
  // Spread over the whole map, not its first corner.
  const auto extent = [](const SparseModel& model) {
    Eigen::AlignedBox3d box;
    for (const SparsePoint& point : model.points) box.extend(point.position);
    return box.diagonal().norm();
  };
  EXPECT_GT(extent(capped), 0.9 * extent(fine));
}

TEST(Export, IsTheSameForAnyNumberOfThreads) {
  const std::string directory = make_test_directory();
  const std::string one = run_export("colmap-text", directory + "/1", {"--threads", "1"});
  const std::string four = run_export("colmap-text", directory + "/4", {"--threads", "4"});
  for (const char* file : {"/cameras.txt", "/images.txt", "/points3D.txt"}) {
    EXPECT_TRUE(read_file(one + file) == read_file(four + file)) << file;
  }
}

TEST(Export, DepthIsThatOfTheWorld) {
  const std::string directory = make_test_directory();
  const std::string out = run_export("depth", directory, {"--depth-kind", "range"});
  std::vector<double> errors_m;
  size_t num_true = 0;
  for (const PosedImage& image : input_model().images) {
    const TrueRanges truth(image.name);
    const cv::Mat mm = cv::imread(out + "/" + fs::path(image.name).stem().string() + ".png", cv::IMREAD_UNCHANGED);
    ASSERT_EQ(mm.type(), CV_16UC1);
    for (int j = 1; j < truth.height; ++j) {
      for (int i = 1; i < truth.width; ++i) {
        const double range_m = 1e-3 * mm.at<uint16_t>(4 * j + 1, 4 * i + 1);  // half a pixel from the sample
        if (truth.at(i, j) == 0.0) continue;
        ++num_true;
        if (range_m > 0.0) errors_m.push_back(std::abs(range_m - truth.at(i, j)));
      }
    }
  }
  EXPECT_GT(errors_m.size(), 8 * num_true / 10);
  EXPECT_LT(median(errors_m), 0.012);
  std::sort(errors_m.begin(), errors_m.end());
  EXPECT_LT(errors_m[errors_m.size() * 9 / 10], 0.06);
}

TEST(Export, ZAndRangeAndExrAgree) {
  const std::string directory = make_test_directory();
  const std::string z = run_export("depth", directory + "/z");
  const std::string range = run_export("depth", directory + "/range", {"--depth-kind", "range", "--exr"});
  const std::string normals = run_export("normals", directory);
  const SparseModel model = input_model();
  const std::string stem = fmt::format("/{}", fs::path(model.images.front().name).stem().string());
  const cv::Mat z_mm = cv::imread(z + stem + ".png", cv::IMREAD_UNCHANGED);
  const cv::Mat range_m = cv::imread(range + stem + ".exr", cv::IMREAD_UNCHANGED);
  const cv::Mat normal = cv::imread(normals + stem + ".png", cv::IMREAD_UNCHANGED);
  ASSERT_EQ(range_m.type(), CV_32FC1);
  ASSERT_EQ(normal.type(), CV_16UC3);
  const Camera& camera = model.cameras.begin()->second;
  size_t num_toward_camera = 0, num_normals = 0;
  for (int y = 0; y < z_mm.rows; y += 7) {
    for (int x = 0; x < z_mm.cols; x += 7) {
      const Eigen::Vector3d bearing = *camera.unproject(Eigen::Vector2d(x, y));
      EXPECT_NEAR(z_mm.at<uint16_t>(y, x), 1000.0 * bearing.z() * static_cast<double>(range_m.at<float>(y, x)), 0.51);
      const cv::Vec3w bgr = normal.at<cv::Vec3w>(y, x);
      if (bgr == cv::Vec3w(0, 0, 0)) continue;
      const Eigen::Vector3d n = Eigen::Vector3d(bgr[2], bgr[1], bgr[0]) * (2.0 / 65535.0) - Eigen::Vector3d::Ones();
      EXPECT_NEAR(n.norm(), 1.0, 1e-3);
      num_toward_camera += n.dot(bearing) < 0 ? 1 : 0;
      ++num_normals;
    }
  }
  EXPECT_GT(num_normals, 1000u);
  EXPECT_EQ(num_toward_camera, num_normals);
}

TEST(Export, GaussianSplattingFolderIsUndistortedAndCentred) {
  const std::string out = run_export("3dgs", make_test_directory());
  const SparseModel model = read_sparse_model(out + "/sparse/0");
  expect_same_poses(model, input_model());
  const Camera& camera = model.cameras.begin()->second;
  EXPECT_EQ(camera.model(), CameraModel::kPinhole);
  EXPECT_EQ(camera.params()[2], 0.5 * (camera.width() - 1));
  EXPECT_EQ(camera.params()[3], 0.5 * (camera.height() - 1));
  EXPECT_TRUE(fs::exists(out + "/sparse/0/points3D.bin"));
  for (const PosedImage& image : model.images) {
    const ImageSize size = read_image_size(out + "/images/" + image.name);
    EXPECT_EQ(size.width, camera.width());
    EXPECT_EQ(size.height, camera.height());
  }
  // The same point has the same colour in the recorded and in the undistorted image.
  const PosedImage& image = model.images.front();
  const ColorImage undistorted = read_color_image(out + "/images/" + image.name);
  const ColorImage recorded = read_color_image(world("images/" + image.name));
  const Camera recorded_camera = input_model().cameras.begin()->second;
  std::vector<double> differences;
  for (const SparsePoint& point : model.points) {
    for (const SparsePoint::Observation& observation : point.track) {
      if (observation.image_id != image.id) continue;
      const Eigen::Vector2d there = *recorded_camera.project(image.camera_from_map * point.position);
      const auto at = [](const ColorImage& picture, const Eigen::Vector2d& p) { return int{bilinear(picture, p)[1]}; };
      differences.push_back(std::abs(at(undistorted, observation.pixel) - at(recorded, there)));
    }
  }
  EXPECT_LT(median(differences), 6.0);
}

TEST(Export, UndistortedGoesWithoutAMap) {
  const std::string directory = make_test_directory();
  const ProcessResult result = run_cpplus({"export", "--format", "undistorted", "--images", world("images"), "--poses",
                                           world("truth/on_map"), "--out", directory + "/out"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const SparseModel model = read_sparse_model(directory + "/out/sparse");
  EXPECT_EQ(model.cameras.begin()->second.model(), CameraModel::kPinhole);
  EXPECT_TRUE(model.points.empty());
  EXPECT_TRUE(fs::exists(directory + "/out/images/" + model.images.front().name));
}

TEST(Export, NerfstudioComesBackThroughImport) {
  const std::string directory = make_test_directory();
  const std::string out = run_export("nerfstudio", directory);
  const ProcessResult result =
      run_cpplus({"import", "nerfstudio", out + "/transforms.json", "--out", directory + "/back"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  expect_same_poses(read_sparse_model(directory + "/back/coarse"), input_model());
  const nlohmann::json root = nlohmann::json::parse(read_file(out + "/transforms.json"));
  for (const auto& frame : root["frames"]) {
    const cv::Mat depth = cv::imread(out + "/" + frame["depth_file_path"].get<std::string>(), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(depth.type(), CV_16UC1);
    EXPECT_EQ(depth.cols, root["w"]);
    EXPECT_EQ(depth.rows, root["h"]);
  }
  EXPECT_GT(read_point_cloud(out + "/sparse.ply").size(), 5000u);
}

TEST(Export, TrajectoriesHoldTheCameraInTheMap) {
  const std::string directory = make_test_directory();
  const std::string tum = run_export("tum", directory, {"--stamps", world("stamps.txt")});
  const std::string kitti = run_export("kitti", directory, {"--stamps", world("stamps.txt")});
  const SparseModel model = input_model();
  const Trajectory trajectory = read_tum(tum + "/trajectory.txt");
  ASSERT_EQ(trajectory.size(), model.images.size());
  const std::vector<std::string> names = lines_of(read_file(kitti + "/images.txt"));
  const std::vector<std::string> rows = lines_of(read_file(kitti + "/poses.txt"));
  ASSERT_EQ(rows.size(), names.size());
  EXPECT_EQ(lines_of(read_file(kitti + "/times.txt")).size(), names.size());
  for (size_t i = 0; i < trajectory.size(); ++i) {
    const auto image = std::find_if(model.images.begin(), model.images.end(),
                                    [&](const PosedImage& posed) { return posed.name == names[i]; });
    ASSERT_NE(image, model.images.end());
    const Eigen::Vector3d center = camera_center(image->camera_from_map);
    EXPECT_LT((trajectory[i].map_from_sensor.translation - center).norm(), 1e-9);
    double value = 0.0;
    std::istringstream words(rows[i]);
    for (int k = 0; k < 4; ++k) words >> value;
    EXPECT_NEAR(value, center.x(), 1e-9);
  }
}

TEST(Export, LocalOriginMovesEverythingTogether) {
  const std::string directory = make_test_directory();
  const SparseModel plain = read_sparse_model(run_export("colmap-text", directory + "/plain"));
  const std::string out = run_export("colmap-text", directory + "/moved", {"--local-origin"});
  const SparseModel moved = read_sparse_model(out);
  std::istringstream text(read_file(out + "/origin.txt"));
  Eigen::Vector3d origin;
  text >> origin.x() >> origin.y() >> origin.z();
  EXPECT_EQ(origin, origin.array().round().matrix());
  ASSERT_EQ(moved.points.size(), plain.points.size());
  EXPECT_LT((moved.points[7].position + origin - plain.points[7].position).norm(), 1e-9);
  for (size_t i = 0; i < plain.images.size(); ++i) {
    EXPECT_LT((moved.images[i].camera_from_map * moved.points[7].position -
               plain.images[i].camera_from_map * plain.points[7].position)
                  .norm(),
              1e-9);
  }
}

TEST(Export, OneUnreadableImageDoesNotStopTheOthers) {
  const std::string directory = make_test_directory();
  fs::copy(world("images"), directory + "/images");
  const SparseModel input = input_model();
  write_file(directory + "/images/" + input.images.at(1).name, "no image");
  const ProcessResult result =
      run_cpplus({"export", "--format", "3dgs", "--map", world("map.pcd"), "--images", directory + "/images", "--poses",
                  world("truth/on_map"), "--out", directory + "/out"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, testing::HasSubstr("warning: skipped: " + directory + "/images/" + input.images[1].name));
  const SparseModel model = read_sparse_model(directory + "/out/sparse/0");
  EXPECT_EQ(model.images.size(), input.images.size() - 1);
  EXPECT_FALSE(fs::exists(directory + "/out/images/" + input.images[1].name));
}

class ExportToColmap : public testing::Test {
 protected:
  /// Runs a command in the test's folder; true when it ended with 0. Its output is then in log.txt.
  bool run(const std::string& command) {
    const std::string line =
        "cd '" + directory + "' && QT_QPA_PLATFORM=offscreen " + command + " > log.txt 2>&1 < /dev/null";
    return std::system(line.c_str()) == 0;
  }
  std::string log() const { return read_file(directory + "/log.txt"); }

  std::string directory = make_test_directory();
};

TEST_F(ExportToColmap, AnalyzesWhatWasWritten) {
  if (!run("command -v colmap")) GTEST_SKIP() << "COLMAP is not installed";
  const SparseModel model = read_sparse_model(run_export("colmap-bin", directory));
  ASSERT_TRUE(run("colmap model_analyzer --path colmap-bin")) << log();
  size_t num_observations = 0;
  for (const SparsePoint& point : model.points) num_observations += point.track.size();
  EXPECT_THAT(log(), testing::HasSubstr(fmt::format("Registered images: {}", model.images.size())));
  EXPECT_THAT(log(), testing::HasSubstr(fmt::format("Points: {}", model.points.size())));
  EXPECT_THAT(log(), testing::HasSubstr(fmt::format("Observations: {}", num_observations)));
}

TEST_F(ExportToColmap, BundleAdjustmentLeavesThePosesWhereTheyAre) {
  if (!run("command -v colmap")) GTEST_SKIP() << "COLMAP is not installed";
  // Recorded images with their distortion, and undistorted ones.
  for (const std::string format : {"colmap-text", "3dgs"}) {
    const std::string in =
        run_export(format, directory, {"--point-voxel-m", "0.25"}) + (format == "3dgs" ? "/sparse/0" : "");
    fs::create_directories(directory + "/adjusted");
    ASSERT_TRUE(run("colmap bundle_adjuster --input_path '" + in + "' --output_path adjusted")) << log();
    const SparseModel before = read_sparse_model(in);
    const SparseModel after = read_sparse_model(directory + "/adjusted");
    ASSERT_EQ(after.images.size(), before.images.size());
    std::map<std::string, Rigid3> poses;
    for (const PosedImage& image : after.images) poses[image.name] = image.camera_from_map;
    double sum_m = 0.0;
    for (const PosedImage& image : before.images) {
      sum_m += (camera_center(poses.at(image.name)) - camera_center(image.camera_from_map)).norm();
    }
    EXPECT_LT(sum_m / static_cast<double>(before.images.size()), 0.002) << format;
  }
}

}  // namespace
}  // namespace cpplus
