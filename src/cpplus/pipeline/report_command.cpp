#include "cpplus/pipeline/report_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "cpplus/core/error.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/map_io.h"
#include "cpplus/pipeline/feature_store.h"
#include "cpplus/pipeline/report_pictures.h"
#include "cpplus/report/report_page.h"
#include "cpplus/report/web_files.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

constexpr double kFloorPlanMarginM = 6.0;
constexpr int kFloorPlanSizePx = 1600;

std::vector<Eigen::Vector2d> camera_places(const SparseModel& model, const TopView& view) {
  std::vector<Eigen::Vector2d> places;
  for (const PosedImage& image : model.images) places.push_back(view * camera_center(image.camera_from_map));
  return places;
}

ReportPage describe(const RefineResult& result) {
  ReportPage page;
  page.title = fs::absolute(result.folder).lexically_normal().string();
  page.report_json = result.report_json;
  page.coarse = result.coarse;
  page.refined = result.refined;
  std::vector<Rigid3> cameras_from_map;
  for (const PosedImage& image : result.coarse.images) cameras_from_map.push_back(image.camera_from_map);
  page.view = TopView(up_axis(cameras_from_map));
  page.floor_plan_bounds = bounds_around(camera_places(result.coarse, page.view), kFloorPlanMarginM);
  page.has_pictures.assign(result.image_names.size(), false);
  return page;
}

void write_floor_plan(const VoxelMap& map, const ReportPage& page, const std::string& path) {
  const std::vector<uint8_t> png = floor_plan_png(map, page.view, page.floor_plan_bounds, kFloorPlanSizePx);
  write_text_file(path, std::string(png.begin(), png.end()));
}

void add_pictures(const RefineResult& result, const ReportCommandOptions& options, const std::string& folder,
                  ReportPage* page, ReportSummary* summary) {
  const PicturePlan plan = plan_pictures(result, folder, options.picture_size_px);
  const std::string floor_plan = folder + "/floor_plan.png";
  std::vector<size_t> drawn;
  if (!plan.missing.empty() || !fs::exists(floor_plan)) {
    const PointMap points = read_map(result.inputs.map, result.stages.voxel_map);
    std::optional<FeatureStore> store =
        open_feature_store(result.inputs.map, points, result.keep_features, result.stages, result.tiles);
    write_floor_plan(points.map, *page, floor_plan);
    GroupedFeatures features(result.inputs.map, points, store ? &*store : nullptr, result.coarse, result.stages,
                             KeptIntensities::kNone, static_cast<size_t>(result.max_group_points), folder);
    drawn = draw_pictures(result, &features, plan.missing, folder, options.picture_size_px);
  }
  page->has_floor_plan = true;
  for (size_t i : plan.kept) page->has_pictures[i] = true;
  for (size_t i : drawn) page->has_pictures[i] = true;
  summary->num_pictures_kept = plan.kept.size();
  summary->num_pictures_made = drawn.size();
}

}  // namespace

void ReportCommandOptions::validate() const {
  if (picture_size_px < 64 || picture_size_px > 8192) {
    throw UsageError(fmt::format("option picture_size_px must be in [64, 8192], got {}", picture_size_px));
  }
}

ReportSummary report_command(const std::string& result_folder, const ReportCommandOptions& options) {
  options.validate();
  const RefineResult result = read_refine_result(result_folder, {options.map, options.images, options.poses});
  const std::string folder = options.out.empty() ? result.folder + "/report" : options.out;
  ReportPage page = describe(result);
  ReportSummary summary;
  summary.num_images = page.has_pictures.size();
  if (options.pictures) add_pictures(result, options, folder, &page, &summary);
  const std::string script = report_page_script(page);
  write_web_files(report_web_files(), folder);
  write_text_file(folder + "/data.js", script);
  summary.page = folder + "/index.html";
  return summary;
}

}  // namespace cpplus
