// Images in two places far from each other: worked on in groups they find the poses that they find all at once.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "cpplus/io/colmap_io.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/stamps_io.h"
#include "cpplus/report/report_page.h"
#include "e2e_world.h"
#include "run_cpplus.h"

namespace cpplus {
namespace {

const Eigen::Vector3d kApart(200.0, 100.0, 0.0);

/// The world twice, kApart from each other: map.pcd, images/, poses/ and stamps.txt.
class TwoPlaces : public testing::Test {
 protected:
  void SetUp() override {
    directory_ = make_test_directory();
    write_map();
    write_images();
  }

  void write_map() const {
    const PointCloud one = read_point_cloud(world_path("map.pcd"));
    PointCloud both = one;
    for (const Eigen::Vector3f& position : one.positions) both.positions.push_back(position + kApart.cast<float>());
    both.intensities.insert(both.intensities.end(), one.intensities.begin(), one.intensities.end());
    write_point_cloud(directory_ + "/map.pcd", both);
  }

  void write_images() const {
    namespace fs = std::filesystem;
    SparseModel model = read_sparse_model(world_path("coarse_small"));
    const std::map<std::string, double> stamps = read_stamps(world_path("stamps.txt"));
    std::ofstream stamps_file(directory_ + "/stamps.txt");
    const size_t count = model.images.size();
    fs::create_directories(directory_ + "/images");
    for (size_t i = 0; i < count; ++i) {
      const PosedImage& first = model.images[i];
      PosedImage second = first;
      second.id += 1000;
      second.name = "second_" + first.name;
      second.camera_from_map.translation -= second.camera_from_map.rotation * kApart;
      fs::copy(world_path("images/" + first.name), directory_ + "/images/" + first.name);
      fs::copy(world_path("images/" + first.name), directory_ + "/images/" + second.name);
      stamps_file.precision(17);
      stamps_file << first.name << ' ' << stamps.at(first.name) << '\n';
      stamps_file << second.name << ' ' << stamps.at(first.name) + 1000.0 << '\n';
      model.images.push_back(second);
    }
    write_sparse_model_text(directory_ + "/poses", model);
  }

  SparseModel refine(const std::string& name, const std::vector<std::string>& more) const {
    const std::string out = directory_ + "/" + name;
    std::vector<std::string> arguments = {"refine",
                                          "--map",
                                          directory_ + "/map.pcd",
                                          "--images",
                                          directory_ + "/images",
                                          "--poses",
                                          directory_ + "/poses",
                                          "--stamps",
                                          directory_ + "/stamps.txt",
                                          "--out",
                                          out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    run_well(arguments);
    return read_sparse_model(out + "/sparse");
  }

  std::string directory_;
};

double distance_m(const Rigid3& a, const Rigid3& b) { return camera_difference(a, b).tail<3>().norm(); }

// The same points 200 m on are rounded otherwise and come in another order, which moves poses by some millimetres.
// Being worked on in groups may not move them by more.
TEST_F(TwoPlaces, GroupsFindThePosesThatAllFindAtOnce) {
  const SparseModel coarse = read_sparse_model(directory_ + "/poses");
  const SparseModel at_once = refine("at_once", {});
  const SparseModel in_groups = refine("in_groups", {"--max-group-points", "1"});
  ASSERT_EQ(in_groups.images.size(), coarse.images.size());
  const size_t num_views = coarse.images.size() / 2;
  double most_by_place_m = 0.0, most_by_groups_m = 0.0, moved_m = 0.0;
  for (size_t i = 0; i < coarse.images.size(); ++i) {
    const Rigid3& pose = at_once.images[i].camera_from_map;
    most_by_groups_m = std::max(most_by_groups_m, distance_m(in_groups.images[i].camera_from_map, pose));
    moved_m += distance_m(pose, coarse.images[i].camera_from_map) / static_cast<double>(coarse.images.size());
    if (i >= num_views) continue;
    Rigid3 second = at_once.images[i + num_views].camera_from_map;
    second.translation += second.rotation * kApart;
    most_by_place_m = std::max(most_by_place_m, distance_m(second, pose));
  }
  EXPECT_LT(most_by_groups_m, most_by_place_m);
  EXPECT_GT(moved_m, 0.01) << "the coarse poses are farther off than that";
}

TEST_F(TwoPlaces, ReportDrawsEachImageInItsGroup) {
  const SparseModel refined = refine("in_groups", {"--max-group-points", "1"});
  run_well({"report", directory_ + "/in_groups"});
  // The same result as if it had been worked on at once.
  const std::string report_json = directory_ + "/in_groups/report.json";
  std::string text = read_file(report_json);
  const std::string option = "\"max_group_points\": ";
  const size_t at = text.find(option + "1");
  ASSERT_NE(at, std::string::npos);
  text.replace(at + option.size(), 1, "100000000");
  std::ofstream(report_json) << text;
  run_well({"report", directory_ + "/in_groups", "--out", directory_ + "/at_once"});
  for (size_t i = 0; i < refined.images.size(); ++i) {
    const PicturePaths paths = picture_paths(i);
    EXPECT_EQ(read_file(directory_ + "/in_groups/report/" + paths.thumbnail),
              read_file(directory_ + "/at_once/" + paths.thumbnail));
    const cv::Mat after = cv::imread(directory_ + "/in_groups/report/" + paths.after, cv::IMREAD_GRAYSCALE);
    const cv::Mat after_at_once = cv::imread(directory_ + "/at_once/" + paths.after, cv::IMREAD_GRAYSCALE);
    ASSERT_FALSE(after.empty()) << paths.after;
    EXPECT_LT(cv::norm(after, after_at_once, cv::NORM_L1) / static_cast<double>(after.total()), 1.0) << paths.after;
  }
}

TEST_F(TwoPlaces, GroupsDoNotDependOnTheNumberOfThreads) {
  refine("one", {"--max-group-points", "1", "--threads", "1"});
  refine("four", {"--max-group-points", "1", "--threads", "4"});
  EXPECT_EQ(read_file(directory_ + "/one/sparse/images.txt"), read_file(directory_ + "/four/sparse/images.txt"));
}

}  // namespace
}  // namespace cpplus
