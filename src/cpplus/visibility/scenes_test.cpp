#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "cpplus/io/colmap_io.h"
#include "cpplus/io/npz.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/visibility/leaf_truth.h"
#include "cpplus/visibility/region_of_interest.h"

namespace cpplus {
namespace {

const std::string kScenes = std::string(CPPLUS_DATA_DIR) + "/truth/";

/// The points of the map that did not move; all of them where the scene has no labels.
PointCloud static_points(const std::string& folder) {
  PointCloud cloud = read_point_cloud(folder + "map.pcd");
  std::ifstream file(folder + "truth/map.label", std::ios::binary);
  const std::vector<char> labels{std::istreambuf_iterator<char>(file), {}};
  if (labels.empty()) return cloud;
  PointCloud kept;
  kept.origin = cloud.origin;
  for (size_t i = 0; i < cloud.size(); ++i) {
    if (labels.at(i) == 0) kept.positions.push_back(cloud.positions[i]);
  }
  return kept;
}

const PosedImage& image_named(const SparseModel& model, const std::string& name) {
  for (const PosedImage& image : model.images)
    if (image.name == name) return image;
  throw std::out_of_range(name);
}

/// Every third image of a scene: the region of interest from the poses of `start` against the truth from truth/on_map.
VisibilityScore score(const std::string& scene, const VoxelMap& map, const std::string& start) {
  const std::string folder = kScenes + scene + "/";
  const SparseModel truth = read_sparse_model(folder + "truth/on_map");
  const SparseModel poses = read_sparse_model(folder + start);
  VisibilityScore result;
  for (size_t i = 0; i < truth.images.size(); i += 3) {
    const PosedImage& image = truth.images[i];
    const Camera& camera = truth.cameras.at(image.camera_id);
    const std::string stem = std::filesystem::path(image.name).stem().string();
    const RangeImage range = read_npz_range(folder + "truth/depth/" + stem + ".npz");
    const VisibilityOptions options;
    const Rigid3& start_pose = image_named(poses, image.name).camera_from_map;
    result.add(judge_leaves(map, camera, image.camera_from_map, range, DepthSampling(), options.max_distance_m),
               find_visible_leaves(map, camera, start_pose, options).leaves);
  }
  return result;
}

class SlowVisibility : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kScenes + GetParam())) GTEST_SKIP() << "no scenes in " << CPPLUS_DATA_DIR;
  }
};

TEST_P(SlowVisibility, KeepsWhatIsSeenAndLittleElse) {
  const VoxelMap map(static_points(kScenes + GetParam() + "/"), VoxelMapOptions());
  const struct {
    const char* start;
    double min_recall;
  } cases[] = {{"truth/on_map", 0.94}, {"coarse_small", 0.94}, {"coarse_medium", 0.93}, {"coarse_large", 0.90}};
  for (const auto& [start, min_recall] : cases) {
    const VisibilityScore result = score(GetParam(), map, start);
    std::cout << GetParam() << ' ' << start << ": recall " << result.recall() << ", precision " << result.precision()
              << '\n';
    EXPECT_GE(result.recall(), min_recall) << start;
    // Trees and slanted road: a tenth of the street's leaves agree with no surface on their ray.
    EXPECT_GE(result.precision(), GetParam() == "street_3" ? 0.80 : 0.84) << start;
  }
}

INSTANTIATE_TEST_SUITE_P(Slow, SlowVisibility, testing::Values("office_1", "street_3", "corner_4"),
                         [](const auto& scene) { return scene.param; });

}  // namespace
}  // namespace cpplus
