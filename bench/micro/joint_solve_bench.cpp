// The joint solve of long sequences: what an image costs from 100 to 10,000 of them. A camera goes along a corridor;
// each image has a pose of its own that is a few pixels off, and patches of the walls found in its next two images.
#include <benchmark/benchmark.h>
#include <cmath>

#include "cpplus/core/random.h"
#include "cpplus/refine/joint_solver.h"

namespace cpplus {
namespace {

constexpr double kStepM = 0.5;
constexpr int kPatches = 40;  // a pair
constexpr size_t kPartners = 2;

Vector6d prior_sigmas() {
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(0.0175), Eigen::Vector3d::Constant(0.1);
  return sigmas;
}

Vector6d drawn(const Vector6d& sigmas, Random* random) {
  Vector6d x;
  for (int k = 0; k < 6; ++k) x(k) = sigmas(k) * random->normal();
  return x;
}

struct Corridor {
  Camera camera = Camera(CameraModel::kPinhole, 1024, 768, {600, 600, 511.5, 383.5});
  std::vector<Rigid3> truth;
  JointProblem problem;

  explicit Corridor(size_t num_images) {
    Random random(1);
    Vector6d drift = Vector6d::Zero();
    for (size_t i = 0; i < num_images; ++i) {
      // Looks along z, which is the corridor's axis.
      truth.emplace_back(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, -kStepM * static_cast<double>(i)));
      drift = 0.9 * drift + drawn(0.1 * prior_sigmas(), &random);
      JointImage image;
      image.camera = &camera;
      image.coarse_camera_from_map = perturb_camera(truth[i], drift);
      image.camera_from_map = perturb_camera(truth[i], drawn(0.05 * prior_sigmas(), &random));
      PoseObservation observation;
      observation.camera_from_map = image.camera_from_map;
      observation.information = (0.05 * prior_sigmas()).cwiseAbs2().cwiseInverse().asDiagonal();
      image.observed = observation;
      image.velocity_per_s = Vector6d::Unit(5);
      problem.images.push_back(image);
      problem.sequences[0].emplace_back(0.5 * static_cast<double>(i), i);
    }
    for (size_t i = 0; i < num_images; ++i) {
      for (size_t j = i + 1; j <= i + kPartners && j < num_images; ++j) add_matches(i, j, &random);
    }
  }

  // Spots of the left and the right wall, 1.5 m to the side.
  void add_matches(size_t i, size_t j, Random* random) {
    for (int k = 0; k < kPatches; ++k) {
      SurfaceMatch m;
      m.image_a = static_cast<uint32_t>(i);
      m.image_b = static_cast<uint32_t>(j);
      m.plane = k % 2;
      const double side = m.plane == 0 ? -1.5 : 1.5;
      const double z = kStepM * static_cast<double>(i) + random->uniform(4.0, 9.0);
      m.point_in_map = Eigen::Vector3d(side, random->uniform(-1.0, 1.0), z);
      m.normal_in_map = Eigen::Vector3d(-side, 0, 0).normalized();
      const auto a = camera.project(truth[i] * m.point_in_map);
      const auto b = camera.project(truth[j] * m.point_in_map);
      if (!a || !b) continue;
      m.pixel_a = *a;
      m.pixel_b = *b + Eigen::Vector2d(0.3 * random->normal(), 0.3 * random->normal());
      problem.matches.push_back(m);
    }
  }
};

void solve(benchmark::State& state) {
  const Corridor corridor(static_cast<size_t>(state.range(0)));
  double error_m = 0.0;
  for (auto _ : state) {
    const JointResult result = solve_joint(corridor.problem, prior_sigmas(), {}, {});
    error_m = 0.0;
    for (size_t i = 0; i < corridor.truth.size(); ++i) {
      error_m += camera_difference(corridor.truth[i], result.poses[i].camera_from_map).tail<3>().norm();
    }
  }
  const double images = static_cast<double>(state.range(0));
  state.counters["error_mm"] = 1e3 * error_m / images;
  state.counters["images_a_second"] = benchmark::Counter(images, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(solve)->Arg(100)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond)->Iterations(1)->UseRealTime();

}  // namespace
}  // namespace cpplus

BENCHMARK_MAIN();
