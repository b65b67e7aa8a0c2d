#include "cpplus/colorize/colorize.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cpplus/colorize/srgb.h"
#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"

namespace cpplus {
namespace {

// The world: a wall in the plane z = 6 with a smooth pattern, a floor y = 1.5 of another colour, and a red board,
// |x| < 0.6 and |y| < 0.6, in the plane z = 3. The camera's axes are the map's (x right, y down, z forward).
constexpr double kWallZ = 6.0, kFloorY = 1.5, kBoardZ = 3.0, kBoardHalf = 0.6;
const Rgb kBoardColor{250, 0, 0};
const Rgb kFloorColor{0, 90, 200};

Rgb wall_color(const Eigen::Vector3d& x) {
  return {40, static_cast<uint8_t>(std::lround(140 + 60 * std::sin(x.x()))),
          static_cast<uint8_t>(std::lround(120 + 40 * std::cos(2 * x.y())))};
}

struct Hit {
  double range = 0.0;
  Rgb color{};
};

Hit trace(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
  Hit hit;
  const auto offer = [&](double range, const Rgb& color) {
    if (range > 0 && (hit.range == 0 || range < hit.range)) hit = {range, color};
  };
  const double wall = (kWallZ - from.z()) / ray.z();
  offer(wall, wall_color(from + wall * ray));
  offer((kFloorY - from.y()) / ray.y(), kFloorColor);
  const double board = (kBoardZ - from.z()) / ray.z();
  const Eigen::Vector3d on_board = from + board * ray;
  if (std::abs(on_board.x()) < kBoardHalf && std::abs(on_board.y()) < kBoardHalf) offer(board, kBoardColor);
  return hit;
}

/// What a slightly distorted camera at `center`, turned by `yaw`, records, and the exact ranges.
ColorView render(const Eigen::Vector3d& center, double yaw) {
  ColorView view;
  view.name = "synthetic";
  view.camera = Camera(CameraModel::kSimpleRadial, 240, 180, {160.0, 119.5, 89.5, -0.05});
  view.camera_from_map = inverse(Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY())), center});
  view.image = ColorImage(240, 180);
  view.depth.camera = view.camera;
  view.depth.cell_px = 2.0;
  view.depth.range = RangeImage(120, 90);
  const Rigid3 map_from_camera = inverse(view.camera_from_map);
  for (int y = 0; y < 180; ++y) {
    for (int x = 0; x < 240; ++x) {
      const Hit hit = trace(center, map_from_camera.rotation * *view.camera.unproject(Eigen::Vector2d(x, y)));
      view.image.at(x, y) = hit.color;
      float& nearest = view.depth.range.at(x / 2, y / 2);
      const auto range = static_cast<float>(hit.range);
      if (nearest == 0 || range < nearest) nearest = range;
    }
  }
  return view;
}

/// Points of the wall, then the floor, then the board, each 5 cm apart.
struct World {
  PointCloud cloud;
  std::vector<Rgb> colors;
  size_t num_wall = 0;
  void add(const Eigen::Vector3d& x, const Rgb& color) {
    cloud.positions.push_back(x.cast<float>());
    colors.push_back(color);
  }
};

World make_world() {
  World world;
  for (double x = -3; x <= 3; x += 0.05) {
    for (double y = -2; y < kFloorY; y += 0.05) world.add({x, y, kWallZ}, wall_color({x, y, kWallZ}));
  }
  world.num_wall = world.cloud.size();
  for (double x = -3; x <= 3; x += 0.05) {
    for (double z = 0.5; z < kWallZ; z += 0.05) world.add({x, kFloorY, z}, kFloorColor);
  }
  for (double x = -0.55; x < kBoardHalf; x += 0.05) {
    for (double y = -0.55; y < kBoardHalf; y += 0.05) world.add({x, y, kBoardZ}, kBoardColor);
  }
  return world;
}

NextColorView stream(std::vector<ColorView> views) {
  return [views = std::move(views), next = size_t{0}]() mutable -> std::optional<ColorView> {
    if (next == views.size()) return {};
    return views[next++];
  };
}

std::vector<ColorView> four_views() {
  return {render({-1.5, 0, 0}, 0.2), render({1.5, 0.2, 0}, -0.2), render({0, -0.5, 0.5}, 0.0), render({0, 1, -1}, 0.1)};
}

int deviation(const Rgb& a, const Rgb& b) {
  int largest = 0;
  for (size_t c = 0; c < 3; ++c) largest = std::max(largest, std::abs(int{a[c]} - int{b[c]}));
  return largest;
}

TEST(Colorize, GivesEverySeenPointItsTrueColour) {
  const World world = make_world();
  const ColorizeResult result = colorize(world.cloud, VoxelMap(world.cloud, {}), stream(four_views()), {});
  EXPECT_EQ(result.images.size(), 4u);
  ASSERT_EQ(result.cloud.size(), world.cloud.size());
  size_t num_wrong = 0;
  for (size_t i = 0; i < world.colors.size(); ++i) {
    // The colours on either side of an edge differ by 100 and more: 8 levels are interpolation, no bleeding.
    if (result.cloud.num_views[i] > 0 && deviation(result.cloud.colors[i], world.colors[i]) > 8) ++num_wrong;
  }
  // Pixels on the line where the wall meets the floor, which is no jump in depth, mix the two.
  EXPECT_LT(num_wrong, world.cloud.size() / 200);
  EXPECT_GT(result.num_colored, world.cloud.size() * 8 / 10);
}

TEST(Colorize, NothingBleedsOverAnOcclusionEdge) {
  const World world = make_world();
  const ColorizeResult result = colorize(world.cloud, VoxelMap(world.cloud, {}), stream({render({0, 0, 0}, 0.0)}), {});
  size_t num_wall_unseen = 0;
  for (size_t i = 0; i < world.num_wall; ++i) {
    if (result.cloud.num_views[i] == 0) {
      ++num_wall_unseen;
    } else {
      EXPECT_LT(result.cloud.colors[i][0], 60)
          << "red of the board on the wall at " << world.cloud.point(i).transpose();
    }
  }
  // The board hides 2.4 m x 2.4 m of the wall from there: 48 x 48 points.
  EXPECT_GT(num_wall_unseen, 48u * 48u);
}

TEST(Colorize, AnOutlierAmongThreeImagesHasNoInfluence) {
  const World world = make_world();
  std::vector<ColorView> views = {render({0, 0, 0}, 0.0), render({0.1, 0, 0}, 0.0), render({0.05, 0, 0}, 0.0)};
  views[1].image.pixels.assign(views[1].image.pixels.size(), Rgb{255, 0, 255});
  const ColorizeResult result = colorize(world.cloud, VoxelMap(world.cloud, {}), stream(views), {});
  size_t num_by_three = 0;
  for (size_t i = 0; i < world.num_wall; ++i) {
    if (result.cloud.num_views[i] < 3 || world.cloud.positions[i].y() > 1.4f) continue;
    ++num_by_three;
    EXPECT_LE(deviation(result.cloud.colors[i], world.colors[i]), 8);
  }
  EXPECT_GT(num_by_three, 500u);
}

/// The image as a camera with another exposure records it.
void expose(double gain, ColorView* view) {
  for (Rgb& pixel : view->image.pixels) {
    for (uint8_t& channel : pixel) {
      channel = static_cast<uint8_t>(std::lround(level_of_light(static_cast<float>(gain) * light_of_level(channel))));
    }
  }
}

TEST(Colorize, ImagesOfDifferentExposureGiveOneColourWithoutASeam) {
  const World world = make_world();
  const VoxelMap map(world.cloud, {});
  std::vector<ColorView> views = {render({-1.5, 0, 0}, 0.2), render({1.5, 0.2, 0}, -0.2)};
  const ColorizeResult even = colorize(world.cloud, map, stream(views), {});
  expose(0.7, &views[0]);
  expose(1.3, &views[1]);
  const ColorizeResult result = colorize(world.cloud, map, stream(views), {});
  EXPECT_NEAR(result.images[1].exposure.log_gain - result.images[0].exposure.log_gain, std::log(1.3 / 0.7), 0.01);
  // As bright as an image between the two, by the mean of the log gains, wherever a point's colour comes from.
  const double mean_gain = std::sqrt(0.7 * 1.3);
  size_t num_compared = 0, num_off = 0;
  for (size_t i = 0; i < world.num_wall; ++i) {
    if (result.cloud.num_views[i] == 0) continue;
    ++num_compared;
    for (size_t c = 0; c < 3; ++c) {
      const float expected = level_of_light(static_cast<float>(mean_gain) * light_of_level(even.cloud.colors[i][c]));
      if (std::abs(static_cast<float>(result.cloud.colors[i][c]) - expected) > 4.0f) {
        ++num_off;
        break;
      }
    }
  }
  EXPECT_GT(num_compared, world.num_wall / 2);
  EXPECT_LT(num_off, num_compared / 100);
  ColorizeOptions off;
  off.exposure.gains = false;
  const ColorizeResult seamed = colorize(world.cloud, map, stream(views), off);
  int largest = 0;
  for (size_t i = 0; i < world.num_wall; ++i) {
    largest = std::max(largest, deviation(seamed.cloud.colors[i], result.cloud.colors[i]));
  }
  EXPECT_GT(largest, 15) << "without gains the seam must show, or this test proves nothing";
}

TEST(Colorize, KeepsTheInputsOrderAndAttributesAndShowsUnseenPointsByIntensity) {
  PointCloud cloud;
  cloud.origin = {400000, 5000000, 100};
  cloud.positions = {{0, 0, 6}, {0, 0, -6}, {NAN, 0, 6}, {0.5f, 0, 6}};
  cloud.intensities = {10, 50, 100, 20};
  cloud.stamps_s = {1, 2, 3, 4};
  ColorView view;
  view.name = "flat";
  view.image_id = 42;
  view.camera = Camera(CameraModel::kPinhole, 100, 80, {60.0, 60.0, 50.0, 40.0});
  view.camera_from_map = Rigid3{Eigen::Quaterniond::Identity(), -cloud.origin};
  view.image = ColorImage(100, 80, Rgb{1, 2, 3});
  view.depth.camera = view.camera;
  view.depth.range = RangeImage(25, 20, 6.5f);
  const ColorizeResult result = colorize(cloud, VoxelMap(cloud, {}), stream({view}), {});
  EXPECT_EQ(result.num_colored, 2u);
  EXPECT_EQ(result.cloud.num_views, (std::vector<uint16_t>{1, 0, 0, 1}));
  EXPECT_EQ(result.cloud.best_images, (std::vector<uint32_t>{42, 0, 0, 42}));
  EXPECT_EQ(result.cloud.color_spreads, (std::vector<uint8_t>{0, 0, 0, 0}));
  EXPECT_EQ(result.cloud.colors[0], (Rgb{1, 2, 3}));
  EXPECT_EQ(result.cloud.colors[3], (Rgb{1, 2, 3}));
  // The 99th percentile of four intensities is the third: 50 is as bright as grey gets, and so is what lies above.
  EXPECT_EQ(result.cloud.colors[1], (Rgb{160, 160, 160}));
  EXPECT_EQ(result.cloud.colors[2], (Rgb{160, 160, 160}));
  EXPECT_EQ(result.cloud.stamps_s, cloud.stamps_s);
  EXPECT_EQ(result.cloud.intensities, cloud.intensities);
  EXPECT_EQ(result.cloud.origin, cloud.origin);
}

TEST(Colorize, WithoutImagesAllIsMidGrey) {
  PointCloud cloud;
  cloud.positions = {{0, 0, 6}};
  const ColorizeResult result = colorize(cloud, VoxelMap(cloud, {}), stream({}), {});
  EXPECT_EQ(result.num_colored, 0u);
  EXPECT_EQ(result.cloud.colors[0], (Rgb{128, 128, 128}));
}

TEST(Colorize, IsTheSameForAnyNumberOfThreads) {
  const World world = make_world();
  const VoxelMap map(world.cloud, {});
  set_num_threads(1);
  const ColorizeResult one = colorize(world.cloud, map, stream(four_views()), {});
  set_num_threads(4);
  const ColorizeResult four = colorize(world.cloud, map, stream(four_views()), {});
  set_num_threads(0);
  EXPECT_EQ(one.cloud.colors, four.cloud.colors);
  EXPECT_EQ(one.cloud.num_views, four.cloud.num_views);
  EXPECT_EQ(one.cloud.best_images, four.cloud.best_images);
  EXPECT_EQ(one.cloud.color_spreads, four.cloud.color_spreads);
  for (size_t i = 0; i < one.images.size(); ++i) {
    EXPECT_EQ(one.images[i].exposure.log_gain, four.images[i].exposure.log_gain);
  }
}

TEST(Colorize, RejectsOptionsOutOfRange) {
  ColorizeOptions options;
  options.max_samples = 0;
  EXPECT_THROW(colorize({}, {}, stream({}), options), Error);
}

}  // namespace
}  // namespace cpplus
