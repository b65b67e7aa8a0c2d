#include "cpplus/io/colmap_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "cpplus/core/error.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

constexpr double kPixelShift = 0.5;

}  // namespace

void shift_principal_point(CameraModel model, double shift, std::vector<double>* params) {
  const std::optional<size_t> first = camera_model_principal_point_index(model);
  if (!first) return;
  for (size_t i = *first; i < std::min(*first + 2, params->size()); ++i) (*params)[i] += shift;
}

void SparseModelBuilder::add_camera(const std::string& where, uint32_t id, CameraModel model, uint64_t width,
                                    uint64_t height, std::vector<double> params) {
  constexpr uint64_t kMaxSide = std::numeric_limits<int>::max();
  if (width > kMaxSide || height > kMaxSide) {
    throw Error(fmt::format("{}: camera {}: size {} x {} is not plausible", where, id, width, height));
  }
  shift_principal_point(model, -kPixelShift, &params);
  try {
    const Camera camera(model, static_cast<int>(width), static_cast<int>(height), std::move(params));
    if (!model_.cameras.emplace(id, camera).second) throw Error("occurs twice");
  } catch (const Error& error) {
    throw Error(fmt::format("{}: camera {}: {}", where, id, error.what()));
  }
}

void SparseModelBuilder::add_image(const std::string& where, uint32_t id, const Eigen::Matrix<double, 7, 1>& pose,
                                   uint32_t camera_id, const std::string& name, std::vector<Eigen::Vector2d> pixels) {
  const auto fail = [&](const std::string& what) {
    throw Error(fmt::format("{}: image {} {}: {}", where, id, in_quotes(name), what));
  };
  if (name.empty()) fail("has no name");
  if (!pose.allFinite()) fail("its pose is not finite");
  if (model_.cameras.count(camera_id) == 0) fail(fmt::format("its camera {} is missing", camera_id));
  if (!names_.insert(name).second) fail("the name occurs twice");
  const Eigen::Quaterniond rotation(pose[0], pose[1], pose[2], pose[3]);
  constexpr double kMaxNormError = 0.01;
  if (std::abs(rotation.norm() - 1.0) > kMaxNormError) {
    fail(fmt::format("its quaternion {} {} {} {} has length {:.6g}, not 1", pose[0], pose[1], pose[2], pose[3],
                     rotation.norm()));
  }
  PosedImage image;
  image.id = id;
  image.name = name;
  image.camera_id = camera_id;
  // What is unit to rounding stays untouched, so that reading and writing again changes no digit.
  constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
  image.camera_from_map.rotation =
      std::abs(rotation.squaredNorm() - 1.0) <= kRounding ? rotation : rotation.normalized();
  image.camera_from_map.translation = pose.tail<3>();
  for (Eigen::Vector2d& pixel : pixels) {
    if (!pixel.allFinite()) fail("one of its observations is not finite");
    pixel.array() -= kPixelShift;
  }
  if (!pixels_.emplace(id, std::move(pixels)).second) fail("the id occurs twice");
  model_.images.push_back(std::move(image));
}

void SparseModelBuilder::add_point(const std::string& where, uint64_t id, const Eigen::Vector3d& position,
                                   const Rgb& color, double error_px, const std::vector<TrackElement>& track) {
  const auto fail = [&](const std::string& what) { throw Error(fmt::format("{}: point {}: {}", where, id, what)); };
  if (!position.allFinite()) fail("its position is not finite");
  if (!point_ids_.insert(id).second) fail("the id occurs twice");
  SparsePoint point;
  point.id = id;
  point.position = position;
  point.color = color;
  point.error_px = error_px;
  point.track.reserve(track.size());
  for (const TrackElement& element : track) {
    const auto pixels = pixels_.find(element.image_id);
    if (pixels == pixels_.end()) fail(fmt::format("its track names image {}, which is missing", element.image_id));
    if (element.observation >= pixels->second.size()) {
      fail(fmt::format("its track names observation {} of image {}, which has {}", element.observation,
                       element.image_id, pixels->second.size()));
    }
    point.track.push_back({element.image_id, pixels->second[element.observation]});
  }
  model_.points.push_back(std::move(point));
}

ObservationLists list_observations(const SparseModel& model) {
  ObservationLists lists;
  for (const PosedImage& image : model.images) lists.of_image[image.id];
  lists.tracks.reserve(model.points.size());
  for (const SparsePoint& point : model.points) {
    std::vector<TrackElement>& track = lists.tracks.emplace_back();
    for (const SparsePoint::Observation& observation : point.track) {
      const auto list = lists.of_image.find(observation.image_id);
      if (list == lists.of_image.end()) {
        throw Error(fmt::format("cannot write the model: point {} is seen by image {}, which is missing", point.id,
                                observation.image_id));
      }
      track.push_back({observation.image_id, static_cast<uint32_t>(list->second.size())});
      list->second.push_back({observation.pixel.array() + kPixelShift, point.id});
    }
  }
  return lists;
}

}  // namespace cpplus
