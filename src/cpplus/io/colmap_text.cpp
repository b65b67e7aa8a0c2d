#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <string_view>

#include "cpplus/core/error.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/colmap_model.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;

std::string place(const BlockReader& reader) { return fmt::format("{}:{}", reader.path(), reader.line_number()); }

/// Takes the words of one line as the fields of a record.
class Fields {
 public:
  Fields(const BlockReader& reader, std::string_view line) : reader_(reader), rest_(line) {}

  double real(const char* name) { return number<double>(name, parse_double); }
  uint64_t whole(const char* name, uint64_t largest) {
    const uint64_t value = number<uint64_t>(name, parse_uint);
    if (value > largest) throw Error(fmt::format("{}: {} {} is too large", place(reader_), name, value));
    return value;
  }
  uint32_t id(const char* name) { return static_cast<uint32_t>(whole(name, UINT32_MAX)); }
  std::string_view word() { return next_word(&rest_); }
  bool at_end() const { return trim(rest_).empty(); }
  std::string_view rest() const { return trim(rest_); }

 private:
  template <typename Number, typename Parse>
  Number number(const char* name, const Parse& parse) {
    const std::string_view text = next_word(&rest_);
    const std::optional<Number> value = parse(text);
    if (!value) {
      throw Error(text.empty()
                      ? fmt::format("{}: {} is missing", place(reader_), name)
                      : fmt::format("{}: {} is not a valid number: {}", place(reader_), name, in_quotes(text)));
    }
    return *value;
  }

  const BlockReader& reader_;
  std::string_view rest_;
};

/// The next line that is neither empty nor a comment.
bool take_record(BlockReader* reader, std::string_view* line) {
  while (reader->take_line(line)) {
    *line = trim(*line);
    if (!line->empty() && line->front() != '#') return true;
  }
  return false;
}

void read_cameras(const std::string& path, SparseModelBuilder* builder) {
  BlockReader reader(path);
  std::string_view line;
  while (take_record(&reader, &line)) {
    Fields fields(reader, line);
    const uint32_t id = fields.id("CAMERA_ID");
    const std::string name(fields.word());
    const std::optional<CameraModel> model = camera_model_from_name(name);
    if (!model) throw Error(fmt::format("{}: camera {}: unknown camera model {}", place(reader), id, in_quotes(name)));
    const uint64_t width = fields.whole("WIDTH", UINT64_MAX);
    const uint64_t height = fields.whole("HEIGHT", UINT64_MAX);
    std::vector<double> params;
    while (!fields.at_end()) params.push_back(fields.real("PARAMS"));
    builder->add_camera(place(reader), id, *model, width, height, std::move(params));
  }
}

void read_images(const std::string& path, SparseModelBuilder* builder) {
  BlockReader reader(path);
  std::string_view line;
  while (take_record(&reader, &line)) {
    const std::string where = place(reader);
    Fields fields(reader, line);
    const uint32_t id = fields.id("IMAGE_ID");
    Eigen::Matrix<double, 7, 1> pose;
    constexpr const char* kPoseFields[] = {"QW", "QX", "QY", "QZ", "TX", "TY", "TZ"};
    for (int i = 0; i < 7; ++i) pose[i] = fields.real(kPoseFields[i]);
    const uint32_t camera_id = fields.id("CAMERA_ID");
    const std::string name(fields.rest());  // may contain blanks

    // Each image has a second line, which is often empty; the last one may be missing.
    std::vector<Eigen::Vector2d> pixels;
    if (reader.take_line(&line)) {
      Fields observations(reader, line);
      while (!observations.at_end()) {
        const double x = observations.real("X of POINTS2D (the second line of an image)");
        const double y = observations.real("Y of POINTS2D (the second line of an image)");
        const std::string_view point = observations.word();
        if (!parse_int(point) && !parse_uint(point)) {
          throw Error(fmt::format("{}: POINT3D_ID (the second line of an image) is not a valid number: {}",
                                  place(reader), in_quotes(point)));
        }
        pixels.emplace_back(x, y);
      }
    }
    builder->add_image(where, id, pose, camera_id, name, std::move(pixels));
  }
}

void read_points(const std::string& path, SparseModelBuilder* builder) {
  BlockReader reader(path);
  std::string_view line;
  std::vector<TrackElement> track;
  while (take_record(&reader, &line)) {
    Fields fields(reader, line);
    const uint64_t id = fields.whole("POINT3D_ID", UINT64_MAX);
    Eigen::Vector3d position;
    for (int axis = 0; axis < 3; ++axis) position[axis] = fields.real("XYZ");
    Rgb color;
    for (uint8_t& channel : color) channel = static_cast<uint8_t>(fields.whole("RGB", 255));
    const double error_px = fields.real("ERROR");
    track.clear();
    while (!fields.at_end()) {
      const uint32_t image_id = fields.id("TRACK IMAGE_ID");
      track.push_back({image_id, fields.id("TRACK POINT2D_IDX")});
    }
    builder->add_point(place(reader), id, position, color, error_px, track);
  }
}

void write_images(const SparseModel& model, const ObservationLists& lists, std::ostream* stream) {
  *stream << "# Image list with two lines of data per image:\n"
             "#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
             "#   POINTS2D[] as (X, Y, POINT3D_ID)\n"
          << fmt::format("# Number of images: {}\n", model.images.size());
  for (const PosedImage& image : model.images) {
    const Eigen::Quaterniond& q = image.camera_from_map.rotation;
    const Eigen::Vector3d& t = image.camera_from_map.translation;
    *stream << fmt::format("{} {} {} {} {} {} {} {} {} {}\n", image.id, q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z(),
                           image.camera_id, image.name);
    const char* separator = "";
    for (const ObservationLists::Observation& observation : lists.of_image.at(image.id)) {
      *stream << fmt::format("{}{} {} {}", separator, observation.pixel.x(), observation.pixel.y(),
                             observation.point_id);
      separator = " ";
    }
    *stream << "\n";
  }
}

void write_points(const SparseModel& model, const ObservationLists& lists, std::ostream* stream) {
  *stream << "# 3D point list with one line of data per point:\n"
             "#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n"
          << fmt::format("# Number of points: {}\n", model.points.size());
  for (size_t i = 0; i < model.points.size(); ++i) {
    const SparsePoint& point = model.points[i];
    *stream << fmt::format("{} {} {} {} {} {} {} {}", point.id, point.position.x(), point.position.y(),
                           point.position.z(), point.color[0], point.color[1], point.color[2], point.error_px);
    for (const TrackElement& element : lists.tracks[i]) {
      *stream << fmt::format(" {} {}", element.image_id, element.observation);
    }
    *stream << "\n";
  }
}

}  // namespace

SparseModel read_sparse_model_text(const std::string& directory) {
  const fs::path folder(directory);
  SparseModelBuilder builder;
  read_cameras((folder / "cameras.txt").string(), &builder);
  read_images((folder / "images.txt").string(), &builder);
  if (fs::exists(folder / "points3D.txt")) read_points((folder / "points3D.txt").string(), &builder);
  return builder.take();
}

void write_sparse_model_text(const std::string& directory, const SparseModel& model) {
  const fs::path folder(directory);
  if (fs::exists(folder / "cameras.bin") || fs::exists(folder / "images.bin")) {
    throw Error(fmt::format(
        "{}: cannot write a text model: the folder holds a binary one (*.bin), which readers prefer", directory));
  }
  const ObservationLists lists = list_observations(model);
  AtomicFile cameras((folder / "cameras.txt").string());
  AtomicFile images((folder / "images.txt").string());
  AtomicFile points((folder / "points3D.txt").string());
  cameras.stream() << "# Camera list with one line of data per camera:\n"
                      "#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
                   << fmt::format("# Number of cameras: {}\n", model.cameras.size());
  for (const auto& [id, camera] : model.cameras) {
    std::vector<double> params = camera.params();
    shift_principal_point(camera.model(), 0.5, &params);
    cameras.stream() << fmt::format("{} {} {} {}", id, camera_model_name(camera.model()), camera.width(),
                                    camera.height());
    for (const double param : params) cameras.stream() << fmt::format(" {}", param);
    cameras.stream() << "\n";
  }
  write_images(model, lists, &images.stream());
  write_points(model, lists, &points.stream());
  cameras.commit();
  images.commit();
  points.commit();
}

}  // namespace cpplus
