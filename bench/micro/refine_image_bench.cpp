// What the stages of `cpplus refine` cost an image, beside reading the image and OpenCV's Canny detector on it. One
// thread, the map's features known; "Time" and "CPU" are means an image over the images of a scene.
//
// usage: refine_image_bench [benchmark options] SCENE [POSES]     SCENE: a folder with map.pcd, images/ and POSES
#include <benchmark/benchmark.h>

#include <cstdio>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "cpplus/core/parallel.h"
#include "cpplus/core/progress.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/map_io.h"
#include "cpplus/pipeline/refine_images.h"

namespace cpplus::bench {
namespace {

struct View {
  std::string path;
  std::string name;
  const Camera* camera = nullptr;
  Rigid3 camera_from_map;
  GrayImage image;
  ImageEdges image_edges;
  PlaneBuffer planes;
  EdgesInView seen;  // from the coarse pose
  Rigid3 refined_camera_from_map;
  JointView joint;
};

struct Scene {
  RefineImagesOptions options;
  SparseModel model;
  MapFeatures features;
  std::vector<View> views;

  PoseGuess guess(const View& view) const { return {view.camera_from_map, options.refine.prior.sigmas()}; }
  ImageReport refine(const View& view, const GrayImage& image) const {
    return refine_image(
        features, view.name, *view.camera, view.camera_from_map, guess(view), [&] { return image; }, options);
  }
};

void load(const std::string& folder, const std::string& poses, Scene* scene) {
  scene->model = read_sparse_model(folder + "/" + poses);
  Progress progress("map", kMapSteps);
  scene->features =
      extract_map_features(read_map(folder + "/map.pcd", scene->options.voxel_map), scene->options, &progress);
  for (const PosedImage& image : scene->model.images) {
    View view;
    view.path = folder + "/images/" + image.name;
    view.name = image.name;
    view.camera = &scene->model.cameras.at(image.camera_id);
    view.camera_from_map = image.camera_from_map;
    view.image = read_gray_image(view.path);
    view.image_edges = detect_image_edges(view.image, scene->options.image_edges);
    view.planes = render_plane_buffer(scene->features.map, scene->features.planes, scene->features.surface,
                                      *view.camera, view.camera_from_map, scene->options.visibility);
    view.seen = find_edges_in_view(scene->features, *view.camera, view.camera_from_map, scene->options);
    view.refined_camera_from_map = scene->refine(view, view.image).camera_from_map;
    view.joint =
        prepare_joint_view(scene->features, *view.camera, view.refined_camera_from_map, view.image, scene->options);
    scene->views.push_back(std::move(view));
  }
}

// The yardstick: what any method pays to look at an image at all.
void decode_and_canny(const View& view) {
  const cv::Mat gray = cv::imread(view.path, cv::IMREAD_GRAYSCALE);
  cv::Mat blurred;
  cv::Mat edges;
  cv::GaussianBlur(gray, blurred, cv::Size(), 1.0);
  cv::Canny(blurred, edges, 40, 100);
  benchmark::DoNotOptimize(edges.data);
}

using Stage = std::function<void(const View&)>;

void run_on_all(benchmark::State& state, const Scene& scene, const Stage& stage) {
  const auto count = static_cast<benchmark::IterationCount>(scene.views.size());
  while (state.KeepRunningBatch(count)) {
    for (const View& view : scene.views) stage(view);
  }
}

void register_all(const Scene& s) {
  const auto add = [&](const char* name, const Stage& stage) {
    benchmark::RegisterBenchmark(name, [&s, stage](benchmark::State& state) {
      run_on_all(state, s, stage);
    })->Unit(benchmark::kMillisecond);
  };
  add("DecodeAndCanny", decode_and_canny);
  add("Alone", [&s](const View& v) { s.refine(v, read_gray_image(v.path)); });
  add("Alone/decode", [](const View& v) { read_gray_image(v.path); });
  add("Alone/blur", [&s](const View& v) { measure_blur(v.image, s.options.blur); });
  add("Alone/visibility", [&s](const View& v) {
    render_plane_buffer(s.features.map, s.features.planes, s.features.surface, *v.camera, v.camera_from_map,
                        s.options.visibility);
  });
  add("Alone/silhouettes", [&s](const View& v) {
    find_silhouettes(s.features.map, s.features.leaf_spacing, v.planes, s.options.silhouettes);
  });
  add("Alone/samples", [&s](const View& v) {
    sample_visible_edges(v.seen.edges, *v.camera, v.camera_from_map, v.planes, s.options.samples);
  });
  add("Alone/image_edges", [&s](const View& v) { detect_image_edges(v.image, s.options.image_edges); });
  add("Alone/refine", [&s](const View& v) {
    if (v.seen.samples.empty()) return;
    refine_pose(*v.camera, v.camera_from_map, s.guess(v), v.seen.edges, v.seen.samples, v.image_edges,
                s.options.refine);
  });
  add("Joint/view", [&s](const View& v) {
    prepare_joint_view(s.features, *v.camera, v.refined_camera_from_map, v.image, s.options);
  });
  add("Joint/patches",
      [&s](const View& v) { prepare_patch_view(v.image, v.planes, v.joint.patches.raster, s.options.patches); });
  add("Joint/match_next", [&s](const View& v) {
    const View& next = &v == &s.views.back() ? s.views.front() : *(&v + 1);
    match_patches(v.joint.patches, next.joint.patches, s.options.patches);
  });
}

}  // namespace
}  // namespace cpplus::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (argc < 2) {
    std::fprintf(stderr, "usage: refine_image_bench [benchmark options] SCENE [POSES]\n");
    return 2;
  }
  const std::string folder = argv[1];
  try {
    cpplus::set_num_threads(1);
    cv::setNumThreads(1);
    cpplus::bench::Scene scene;
    cpplus::bench::load(folder, argc > 2 ? argv[2] : "coarse_medium", &scene);
    cpplus::bench::register_all(scene);
    benchmark::RunSpecifiedBenchmarks();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "refine_image_bench: %s\n", error.what());
    return 1;
  }
  return 0;
}
