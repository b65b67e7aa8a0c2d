#include "cpplus/io/ros_messages.h"

#include <fmt/format.h>

#include <cstring>

#include "cpplus/core/error.h"
#include "cpplus/io/cloud_builder.h"
#include "cpplus/io/rig_formats.h"
#include "cpplus/io/rotation_check.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

/// Takes the fields of a message one after the other; ROS 1 packs them without padding, little-endian.
class Cursor {
 public:
  Cursor(const std::string& where, const uint8_t* data, size_t size) : where_(where), data_(data), size_(size) {}

  template <typename T>
  T take() {
    T value;
    std::memcpy(&value, bytes(sizeof(T)), sizeof(T));
    return value;
  }

  const uint8_t* bytes(size_t count) {
    if (count > size_ - at_) throw Error(fmt::format("{}: the message is broken off", where_));
    at_ += count;
    return data_ + at_ - count;
  }

  std::string text() {
    const uint32_t length = take<uint32_t>();
    return {reinterpret_cast<const char*>(bytes(length)), length};
  }

  double stamp() {
    const uint32_t seconds = take<uint32_t>();
    return seconds + 1e-9 * take<uint32_t>();
  }

  /// std_msgs/Header.
  RosHeader header() {
    take<uint32_t>();  // seq
    const double stamp_s = stamp();
    return {stamp_s, frame()};
  }

  /// A frame's name; some drivers begin it with a slash.
  std::string frame() {
    const std::string name = text();
    return name.starts_with("/") ? name.substr(1) : name;
  }

  Rigid3 pose() {
    double v[7];
    for (double& value : v) value = take<double>();
    return {checked_rotation(where_, Eigen::Quaterniond(v[6], v[3], v[4], v[5])), Eigen::Vector3d(v[0], v[1], v[2])};
  }

  std::vector<double> doubles(size_t count) {
    const uint8_t* first = bytes(count * sizeof(double));  // before any memory is taken for what may not be there
    std::vector<double> values(count);
    if (count > 0) std::memcpy(values.data(), first, count * sizeof(double));
    return values;
  }

 private:
  const std::string& where_;
  const uint8_t* data_;
  size_t size_;
  size_t at_ = 0;
};

/// Where a pixel's red, green and blue are, and how far apart pixels stand.
struct Encoding {
  size_t channels = 0;
  size_t red = 0, green = 0, blue = 0;
};

Encoding encoding_of(const std::string& where, const std::string& name) {
  if (name == "rgb8") return {3, 0, 1, 2};
  if (name == "bgr8") return {3, 2, 1, 0};
  if (name == "rgba8") return {4, 0, 1, 2};
  if (name == "bgra8") return {4, 2, 1, 0};
  if (name == "mono8" || name == "8UC1") return {1, 0, 0, 0};
  throw Error(fmt::format("{}: unknown image encoding {}: known are rgb8, bgr8, rgba8, bgra8 and mono8", where,
                          in_quotes(name)));
}

ScalarType scalar_of(const std::string& where, uint8_t datatype) {
  constexpr ScalarType kTypes[] = {ScalarType::kInt8,  ScalarType::kUint8,  ScalarType::kInt16,   ScalarType::kUint16,
                                   ScalarType::kInt32, ScalarType::kUint32, ScalarType::kFloat32, ScalarType::kFloat64};
  if (datatype < 1 || datatype > 8) throw Error(fmt::format("{}: unknown type {} of a field", where, datatype));
  return kTypes[datatype - 1];
}

/// The cloud without points at the origin.
PointCloud without_origin(const PointCloud& cloud) {
  PointCloud kept;
  kept.origin = cloud.origin;
  for (size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.point(i).isZero(0.0)) continue;
    kept.positions.push_back(cloud.positions[i]);
    if (!cloud.intensities.empty()) kept.intensities.push_back(cloud.intensities[i]);
    if (!cloud.colors.empty()) kept.colors.push_back(cloud.colors[i]);
    if (!cloud.stamps_s.empty()) kept.stamps_s.push_back(cloud.stamps_s[i]);
  }
  return kept;
}

std::vector<PointField> take_fields(Cursor* cursor, const std::string& where) {
  std::vector<PointField> fields;
  const uint32_t count = cursor->take<uint32_t>();
  for (uint32_t i = 0; i < count; ++i) {
    PointField field;
    field.name = cursor->text();
    field.offset = cursor->take<uint32_t>();
    field.type = scalar_of(where, cursor->take<uint8_t>());
    field.count = cursor->take<uint32_t>();
    fields.push_back(field);
  }
  assign_roles(&fields);
  return fields;
}

}  // namespace

RosImage parse_ros_image(const std::string& where, const uint8_t* data, size_t size) {
  Cursor cursor(where, data, size);
  RosImage image;
  image.header = cursor.header();
  const uint32_t height = cursor.take<uint32_t>();
  const uint32_t width = cursor.take<uint32_t>();
  const Encoding encoding = encoding_of(where, cursor.text());
  cursor.take<uint8_t>();  // is_bigendian: of no meaning for single bytes
  const uint32_t step = cursor.take<uint32_t>();
  const uint32_t length = cursor.take<uint32_t>();
  constexpr uint32_t kMaxSide = 1u << 16;
  if (width == 0 || height == 0 || width > kMaxSide || height > kMaxSide || step < width * encoding.channels ||
      length < static_cast<uint64_t>(step) * height) {
    throw Error(
        fmt::format("{}: an image of {}x{} does not fit into {} bytes of step {}", where, width, height, length, step));
  }
  const uint8_t* pixels = cursor.bytes(length);
  image.pixels = ColorImage(static_cast<int>(width), static_cast<int>(height));
  for (uint32_t y = 0; y < height; ++y) {
    const uint8_t* pixel = pixels + static_cast<size_t>(y) * step;
    for (uint32_t x = 0; x < width; ++x, pixel += encoding.channels) {
      image.pixels.at(static_cast<int>(x), static_cast<int>(y)) = {pixel[encoding.red], pixel[encoding.green],
                                                                   pixel[encoding.blue]};
    }
  }
  return image;
}

RosCompressedImage parse_ros_compressed_image(const std::string& where, const uint8_t* data, size_t size) {
  Cursor cursor(where, data, size);
  RosCompressedImage image;
  image.header = cursor.header();
  const std::string format =
      cursor.text();  // "jpeg", "bgr8; jpeg compressed bgr8", ...: what it is stands in its bytes
  image.bytes = cursor.text();
  if (image.bytes.starts_with("\xff\xd8")) {
    image.extension = ".jpg";
  } else if (image.bytes.starts_with("\x89PNG")) {
    image.extension = ".png";
  } else {
    throw Error(fmt::format("{}: a compressed image that is neither JPEG nor PNG: {}", where, in_quotes(format)));
  }
  return image;
}

RosCloud parse_ros_point_cloud(const std::string& where, const uint8_t* data, size_t size) {
  Cursor cursor(where, data, size);
  RosCloud result;
  result.header = cursor.header();
  const uint32_t height = cursor.take<uint32_t>();
  const uint32_t width = cursor.take<uint32_t>();
  const std::vector<PointField> fields = take_fields(&cursor, where);
  const bool big_endian = cursor.take<uint8_t>() != 0;
  const uint32_t point_step = cursor.take<uint32_t>();
  const uint32_t row_step = cursor.take<uint32_t>();
  const uint32_t length = cursor.take<uint32_t>();
  const uint8_t* bytes = cursor.bytes(length);
  for (const PointField& field : fields) {
    if (field.offset + field.count * scalar_size(field.type) > point_step) {
      throw Error(fmt::format("{}: field {} does not fit into a point of {} bytes", where, field.name, point_step));
    }
  }
  if (static_cast<uint64_t>(width) * point_step > row_step || static_cast<uint64_t>(row_step) * height > length) {
    throw Error(fmt::format("{}: {}x{} points do not fit into {} bytes", where, width, height, length));
  }
  const size_t num_points = static_cast<size_t>(width) * height;
  if (num_points == 0) return result;
  if (point_step == 0) throw Error(fmt::format("{}: points of no bytes", where));
  CloudBuilder builder(where, num_points, fields);
  for (size_t i = 0; i < num_points; ++i) {
    const uint8_t* point = bytes + i / width * row_step + i % width * point_step;
    for (const PointField& field : fields) {
      if (field.role != PointRole::kNone) builder.set_from_bytes(i, field, point + field.offset, big_endian);
    }
  }
  ReadCounts counts;
  result.cloud = without_origin(builder.finish(&counts));
  return result;
}

RosCloud parse_livox_custom(const std::string& where, const uint8_t* data, size_t size) {
  Cursor cursor(where, data, size);
  RosCloud result;
  result.header = cursor.header();
  const uint64_t timebase_ns = cursor.take<uint64_t>();
  cursor.take<uint32_t>();  // point_num, repeated below
  cursor.bytes(4);          // lidar_id, rsvd
  const uint32_t count = cursor.take<uint32_t>();
  for (uint32_t i = 0; i < count; ++i) {
    const uint64_t stamp_ns = timebase_ns + cursor.take<uint32_t>();
    const float x = cursor.take<float>(), y = cursor.take<float>(), z = cursor.take<float>();
    const uint8_t reflectivity = cursor.take<uint8_t>();
    cursor.bytes(2);  // tag, line
    const Eigen::Vector3f position(x, y, z);
    if (!position.allFinite() || position.isZero(0.0f)) continue;
    result.cloud.positions.push_back(position);
    result.cloud.intensities.push_back(reflectivity);
    result.cloud.stamps_s.push_back(static_cast<double>(stamp_ns / 1000000000) +
                                    1e-9 * static_cast<double>(stamp_ns % 1000000000));
  }
  return result;
}

RosPoses parse_ros_odometry(const std::string& where, const uint8_t* data, size_t size) {
  Cursor cursor(where, data, size);
  const RosHeader header = cursor.header();
  const std::string child = cursor.frame();
  return {header.frame, child, {{header.stamp_s, cursor.pose()}}};
}

RosPoses parse_ros_path(const std::string& where, const uint8_t* data, size_t size) {
  Cursor cursor(where, data, size);
  RosPoses poses;
  poses.frame = cursor.header().frame;
  const uint32_t count = cursor.take<uint32_t>();
  for (uint32_t i = 0; i < count; ++i) {
    const double stamp_s = cursor.header().stamp_s;
    poses.poses.push_back({stamp_s, cursor.pose()});
  }
  return poses;
}

RosCameraInfo parse_ros_camera_info(const std::string& where, const uint8_t* data, size_t size) {
  Cursor cursor(where, data, size);
  const std::string frame = cursor.header().frame;
  const int height = static_cast<int>(cursor.take<uint32_t>());
  const int width = static_cast<int>(cursor.take<uint32_t>());
  const std::string model = cursor.text();
  const uint32_t count = cursor.take<uint32_t>();
  const std::vector<double> distortion = cursor.doubles(count);
  const std::vector<double> k = cursor.doubles(9);
  return {frame, ros_camera(where, width, height, model, k, distortion)};
}

std::vector<RosTransform> parse_ros_transforms(const std::string& where, const uint8_t* data, size_t size) {
  Cursor cursor(where, data, size);
  std::vector<RosTransform> transforms;
  const uint32_t count = cursor.take<uint32_t>();
  for (uint32_t i = 0; i < count; ++i) {
    RosTransform transform;
    transform.parent = cursor.header().frame;
    transform.child = cursor.frame();
    transform.parent_from_child = cursor.pose();  // translation and quaternion, in the order of a pose
    transforms.push_back(transform);
  }
  return transforms;
}

}  // namespace cpplus
