#include "voxel_map_bench_cloud.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>

#include "cpplus/core/random.h"

namespace cpplus::bench {
namespace {

const Eigen::Vector3d room_size(6.0, 5.0, 3.0);
constexpr double wall_noise_m = 0.015;
constexpr int rooms_a_row = 10;
constexpr int rooms_a_storey = rooms_a_row * rooms_a_row;

struct Box {
  Eigen::Vector3d low, high;

  std::array<double, 3> face_areas() const {
    const Eigen::Vector3d e = high - low;
    return {e.y() * e.z(), e.x() * e.z(), e.x() * e.y()};
  }
  double area() const {
    const std::array<double, 3> a = face_areas();
    return 2 * (a[0] + a[1] + a[2]);
  }
  /// Even by area on the six faces.
  Eigen::Vector3d sample(Random* random) const {
    const std::array<double, 3> areas = face_areas();
    double choice = random->uniform(0, area() / 2);
    int axis = 0;
    while (axis < 2 && choice >= areas[static_cast<size_t>(axis)]) choice -= areas[static_cast<size_t>(axis++)];
    Eigen::Vector3d x;
    for (int i = 0; i < 3; ++i) x[i] = random->uniform(low[i], high[i]);
    x[axis] = (random->next() & 1 ? low[axis] : high[axis]) + wall_noise_m * random->normal();
    return x;
  }
};

/// The room and its furniture.
std::vector<Box> make_room(size_t room, Random* random) {
  const size_t on_storey = room % rooms_a_storey;
  const Eigen::Vector3d index(static_cast<double>(on_storey % rooms_a_row),
                              static_cast<double>(on_storey / rooms_a_row), static_cast<double>(room / rooms_a_storey));
  // Rooms are 0.2 m apart, and nothing lies on a border of the voxels.
  const Eigen::Vector3d low = index.cwiseProduct((room_size.array() + 0.2).matrix()).array() - 20.017;
  std::vector<Box> boxes = {{low, low + room_size}};
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d size(random->uniform(0.4, 1.8), random->uniform(0.4, 1.2), random->uniform(0.4, 2.0));
    const Eigen::Vector3d corner =
        low + Eigen::Vector3d(random->uniform(0, 6 - size.x()), random->uniform(0, 5 - size.y()), 0.0);
    boxes.push_back({corner, corner + size});
  }
  return boxes;
}

PointCloud make_cloud(const World& world) {
  const double density = world.sparse ? 400.0 : 2600.0;
  Random random(1);
  PointCloud cloud;
  cloud.positions.reserve(world.num_points);
  for (size_t room = 0; cloud.size() < world.num_points; ++room) {
    const std::vector<Box> boxes = make_room(room, &random);
    double area = 0;
    for (const Box& box : boxes) area += box.area();
    const size_t end = std::min(world.num_points, cloud.size() + static_cast<size_t>(area * density));
    while (cloud.size() < end) {
      double choice = random.uniform(0, area);
      size_t b = 0;
      while (b + 1 < boxes.size() && choice >= boxes[b].area()) choice -= boxes[b++].area();
      cloud.positions.push_back(boxes[b].sample(&random).cast<float>());
    }
  }
  if (world.shuffled) {
    for (size_t i = cloud.size(); i > 1; --i) std::swap(cloud.positions[i - 1], cloud.positions[random.below(i)]);
  }
  return cloud;
}

}  // namespace

std::string World::name() const {
  return std::to_string(num_points / 1000000) + "M_" + (sparse ? "sparse" : "dense") + (shuffled ? "_shuffled" : "");
}

const PointCloud& cloud_of(const World& world) {
  static World current;
  static PointCloud cloud;
  if (!(current == world)) {
    cloud = PointCloud();
    cloud = make_cloud(world);
    current = world;
  }
  return cloud;
}

Eigen::Vector3f room_center(const Eigen::Vector3f& position) {
  const Eigen::Array3f pitch = room_size.cast<float>().array() + 0.2f;
  const Eigen::Array3f index = ((position.array() + 20.017f + 0.1f) / pitch).floor();
  return index * pitch - 20.017f + 0.5f * room_size.cast<float>().array();
}

void return_memory(benchmark::State* state) {
  state->PauseTiming();
#ifdef __GLIBC__
  malloc_trim(0);
#endif
  state->ResumeTiming();
}

}  // namespace cpplus::bench
