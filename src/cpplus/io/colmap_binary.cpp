#include <fmt/format.h>

#include <cstring>
#include <filesystem>
#include <optional>

#include "cpplus/core/error.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/byte_writer.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/colmap_model.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

template <typename T>
T take(BlockReader* reader) {
  T value;
  std::memcpy(&value, reader->take(sizeof(T)), sizeof(T));
  return value;
}

/// A count whose items take at least `item_size` bytes each; throws where the file is too short for them.
uint64_t take_count(BlockReader* reader, const char* what, uint64_t item_size) {
  const uint64_t count = take<uint64_t>(reader);
  if (count > reader->remaining() / item_size) {
    throw Error(
        fmt::format("{}: truncated: {} {} announced, {} bytes left", reader->path(), count, what, reader->remaining()));
  }
  return count;
}

void read_cameras(const std::string& path, SparseModelBuilder* builder) {
  BlockReader reader(path);
  const uint64_t count = take_count(&reader, "cameras", 24);
  for (uint64_t i = 0; i < count; ++i) {
    const uint32_t id = take<uint32_t>(&reader);
    const int32_t model_id = take<int32_t>(&reader);
    const std::optional<CameraModel> model = camera_model_from_colmap_id(model_id);
    if (!model) throw Error(fmt::format("{}: camera {}: unknown camera model id {}", path, id, model_id));
    const uint64_t width = take<uint64_t>(&reader);
    const uint64_t height = take<uint64_t>(&reader);
    std::vector<double> params(camera_model_num_params(*model));
    for (double& param : params) param = take<double>(&reader);
    builder->add_camera(path, id, *model, width, height, std::move(params));
  }
}

std::string take_name(BlockReader* reader) {
  std::string name;
  constexpr size_t kMaxLength = 4096;
  for (char c = take<char>(reader); c != '\0'; c = take<char>(reader)) {
    name += c;
    if (name.size() > kMaxLength) throw Error(fmt::format("{}: an image name has no end", reader->path()));
  }
  return name;
}

void read_images(const std::string& path, SparseModelBuilder* builder) {
  BlockReader reader(path);
  const uint64_t count = take_count(&reader, "images", 73);
  for (uint64_t i = 0; i < count; ++i) {
    const uint32_t id = take<uint32_t>(&reader);
    Eigen::Matrix<double, 7, 1> pose;
    for (double& value : pose) value = take<double>(&reader);
    const uint32_t camera_id = take<uint32_t>(&reader);
    const std::string name = take_name(&reader);
    std::vector<Eigen::Vector2d> pixels(take_count(&reader, "observations", 24));
    for (Eigen::Vector2d& pixel : pixels) {
      pixel.x() = take<double>(&reader);
      pixel.y() = take<double>(&reader);
      reader.skip(sizeof(uint64_t));  // the 3D point, known from the tracks
    }
    builder->add_image(path, id, pose, camera_id, name, std::move(pixels));
  }
}

void read_points(const std::string& path, SparseModelBuilder* builder) {
  BlockReader reader(path);
  const uint64_t count = take_count(&reader, "points", 51);
  for (uint64_t i = 0; i < count; ++i) {
    const uint64_t id = take<uint64_t>(&reader);
    Eigen::Vector3d position;
    for (double& value : position) value = take<double>(&reader);
    const Rgb color = take<Rgb>(&reader);
    const double error_px = take<double>(&reader);
    std::vector<TrackElement> track(take_count(&reader, "track elements", 8));
    for (TrackElement& element : track) {
      element.image_id = take<uint32_t>(&reader);
      element.observation = take<uint32_t>(&reader);
    }
    builder->add_point(path, id, position, color, error_px, track);
  }
}

void write_cameras(const SparseModel& model, std::ostream* stream) {
  ByteWriter writer(stream);
  writer.put<uint64_t>(model.cameras.size());
  for (const auto& [id, camera] : model.cameras) {
    writer.put<uint32_t>(id);
    writer.put<int32_t>(camera_model_colmap_id(camera.model()));
    writer.put<uint64_t>(static_cast<uint64_t>(camera.width()));
    writer.put<uint64_t>(static_cast<uint64_t>(camera.height()));
    std::vector<double> params = camera.params();
    shift_principal_point(camera.model(), 0.5, &params);
    for (const double param : params) writer.put(param);
  }
}

void write_images(const SparseModel& model, const ObservationLists& lists, std::ostream* stream) {
  ByteWriter writer(stream);
  writer.put<uint64_t>(model.images.size());
  for (const PosedImage& image : model.images) {
    const Eigen::Quaterniond& q = image.camera_from_map.rotation;
    writer.put<uint32_t>(image.id);
    for (const double value : {q.w(), q.x(), q.y(), q.z()}) writer.put(value);
    for (const double value : image.camera_from_map.translation) writer.put(value);
    writer.put<uint32_t>(image.camera_id);
    writer.put_bytes(image.name.c_str(), image.name.size() + 1);
    const auto& observations = lists.of_image.at(image.id);
    writer.put<uint64_t>(observations.size());
    for (const ObservationLists::Observation& observation : observations) {
      writer.put(observation.pixel.x());
      writer.put(observation.pixel.y());
      writer.put<uint64_t>(observation.point_id);
    }
  }
}

void write_points(const SparseModel& model, const ObservationLists& lists, std::ostream* stream) {
  ByteWriter writer(stream);
  writer.put<uint64_t>(model.points.size());
  for (size_t i = 0; i < model.points.size(); ++i) {
    const SparsePoint& point = model.points[i];
    writer.put<uint64_t>(point.id);
    for (const double value : point.position) writer.put(value);
    for (const uint8_t channel : point.color) writer.put(channel);
    writer.put(point.error_px);
    writer.put<uint64_t>(lists.tracks[i].size());
    for (const TrackElement& element : lists.tracks[i]) {
      writer.put<uint32_t>(element.image_id);
      writer.put<uint32_t>(element.observation);
    }
  }
}

}  // namespace

SparseModel read_sparse_model_binary(const std::string& directory) {
  const fs::path folder(directory);
  SparseModelBuilder builder;
  read_cameras((folder / "cameras.bin").string(), &builder);
  read_images((folder / "images.bin").string(), &builder);
  if (fs::exists(folder / "points3D.bin")) read_points((folder / "points3D.bin").string(), &builder);
  return builder.take();
}

void write_sparse_model_binary(const std::string& directory, const SparseModel& model) {
  const fs::path folder(directory);
  const ObservationLists lists = list_observations(model);
  AtomicFile cameras((folder / "cameras.bin").string());
  AtomicFile images((folder / "images.bin").string());
  AtomicFile points((folder / "points3D.bin").string());
  write_cameras(model, &cameras.stream());
  write_images(model, lists, &images.stream());
  write_points(model, lists, &points.stream());
  cameras.commit();
  images.commit();
  points.commit();
}

}  // namespace cpplus
