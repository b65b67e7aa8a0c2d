#include "cpplus/io/las.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "cpplus/core/error.h"
#include "cpplus/io/atomic_file.h"
#include "cpplus/io/byte_writer.h"
#include "cpplus/io/intensity_16_bits.h"
#include "cpplus/io/las_header.h"

namespace cpplus {
namespace {

constexpr double kDefaultScale = 1e-4;  // metres; reaches 214 km around the offset
constexpr size_t kHeaderSize = 375;     // LAS 1.4
constexpr size_t kRecordHeaderSize = 54;
constexpr size_t kExtraBytesEntrySize = 192;

/// Colours of 16 bits become 8 bits by their high byte. Many writers store 8 bits all the same, which only shows when
/// all points have been seen.
bool has_wide_colors(const std::string& path) {
  BlockReader reader(path);
  const LasHeader header = read_las_header(&reader);
  const size_t offset = las_color_offset(header.point_format);
  if (offset == 0) return false;
  for (size_t point = 0; point < header.num_points; ++point) {
    uint16_t channels[3];
    std::memcpy(channels, reader.take(header.record_size) + offset, sizeof(channels));
    constexpr uint16_t kByte = 255;
    if (*std::max_element(channels, channels + 3) > kByte) return true;
  }
  return false;
}

class LasSource : public CloudSource {
 public:
  explicit LasSource(const std::string& path) : reader_(path), header_(read_las_header(&reader_)) {}

  size_t num_points() const override { return header_.num_points; }
  const std::vector<PointField>& fields() const override { return header_.fields; }
  std::optional<LasFrame> las_frame() const override { return header_.frame; }

  void read(size_t count, CloudBuilder* builder) override {
    if (!color_shift_) color_shift_ = has_wide_colors(reader_.path()) ? 8 : 0;
    for (size_t point = 0; point < count; ++point) {
      const uint8_t* record = reader_.take(header_.record_size);
      for (const PointField& field : header_.fields) set(point, field, record, builder);
    }
  }

 private:
  void set(size_t point, const PointField& field, const uint8_t* record, CloudBuilder* builder) const {
    const double value = load_scalar(record + field.offset, field.type, false);
    switch (field.role) {
      case PointRole::kX:
      case PointRole::kY:
      case PointRole::kZ: {
        const int axis = static_cast<int>(field.role) - static_cast<int>(PointRole::kX);
        builder->set(point, field.role, value * header_.frame.scale[axis] + header_.frame.offset[axis]);
        break;
      }
      case PointRole::kRed:
      case PointRole::kGreen:
      case PointRole::kBlue:
        builder->set(point, field.role, static_cast<uint16_t>(value) >> *color_shift_);
        break;
      default:
        builder->set(point, field.role, value);
    }
  }

  BlockReader reader_;
  LasHeader header_;
  std::optional<int> color_shift_;
};

/// The extra bytes of a cloud's points: their description, and how many they are.
struct ExtraBytes {
  std::vector<uint8_t> entries;
  size_t size = 0;

  /// `type`: as LAS 1.4 numbers them: 1 uint8, 3 uint16, 5 uint32.
  void add(uint8_t type, size_t num_bytes, const std::string& name, const std::string& description) {
    const size_t start = entries.size();
    entries.resize(start + kExtraBytesEntrySize, 0);
    entries[start + 2] = type;
    std::copy(name.begin(), name.end(), entries.begin() + static_cast<std::ptrdiff_t>(start + 4));
    std::copy(description.begin(), description.end(), entries.begin() + static_cast<std::ptrdiff_t>(start + 160));
    size += num_bytes;
  }
};

ExtraBytes extra_bytes_of(const PointCloud& cloud) {
  ExtraBytes extra;
  if (!cloud.num_views.empty()) extra.add(3, 2, "num_views", "images that see the point");
  if (!cloud.best_images.empty()) extra.add(5, 4, "best_image", "id of the image that counts");
  if (!cloud.color_spreads.empty()) extra.add(1, 1, "color_spread", "RMS of images, grey levels");
  return extra;
}

/// What the header says of all points, from a first pass over them.
struct Survey {
  PointCloud front;  // the first block without its points: origin and LAS frame
  size_t num_points = 0;
  Eigen::Vector3f lowest = Eigen::Vector3f::Constant(std::numeric_limits<float>::infinity());
  Eigen::Vector3f highest = Eigen::Vector3f::Constant(-std::numeric_limits<float>::infinity());
  bool has_stamps = false;
  bool has_colors = false;
  ExtraBytes extra;
  IntensityFactor intensity_factor;
};

void survey_block(const std::string& path, const PointCloud& block, Survey* survey) {
  for (const Eigen::Vector3f& position : block.positions) {
    if (!position.allFinite()) throw Error(fmt::format("{}: cannot write a point that is not finite to LAS", path));
    survey->lowest = survey->lowest.cwiseMin(position);
    survey->highest = survey->highest.cwiseMax(position);
  }
  survey->intensity_factor.add(block.intensities);
}

Survey survey_points(const std::string& path, const CloudStream& cloud) {
  Survey survey;
  survey.num_points = cloud.num_points;
  bool is_first = true;
  cloud.for_each_block([&](const PointCloud& block) {
    if (is_first) {
      survey.front.origin = block.origin;
      survey.front.las_frame = block.las_frame;
      survey.has_stamps = !block.stamps_s.empty();
      survey.has_colors = !block.colors.empty();
      survey.extra = extra_bytes_of(block);
    }
    is_first = false;
    survey_block(path, block, &survey);
  });
  return survey;
}

/// The grid of the output and the cloud's extent on it.
struct Grid {
  LasFrame frame;
  Eigen::Vector3d min = Eigen::Vector3d::Zero();  // metres, on the grid
  Eigen::Vector3d max = Eigen::Vector3d::Zero();

  double steps(const PointCloud& cloud, const Eigen::Vector3f& position, int axis) const {
    return std::round((cloud.origin[axis] - frame.offset[axis] + static_cast<double>(position[axis])) /
                      frame.scale[axis]);
  }
};

bool fits(const Survey& survey, const Grid& grid) {
  for (int axis = 0; axis < 3; ++axis) {
    constexpr double kLimit = std::numeric_limits<int32_t>::max();
    if (!(grid.steps(survey.front, survey.lowest, axis) >= -kLimit &&
          grid.steps(survey.front, survey.highest, axis) <= kLimit)) {
      return false;
    }
  }
  return true;
}

Grid choose_grid(const std::string& path, const Survey& survey) {
  Grid grid;
  if (survey.front.las_frame) {
    grid.frame = *survey.front.las_frame;
  } else {
    grid.frame.scale.setConstant(kDefaultScale);
    grid.frame.offset = survey.front.origin;
  }
  if (survey.num_points == 0) return grid;
  if (!fits(survey, grid)) {
    grid.frame.offset = survey.front.origin;
    if (!fits(survey, grid)) {
      throw Error(fmt::format("{}: an extent of {:.0f} m does not fit into LAS coordinates with a scale of {} m", path,
                              (survey.highest - survey.lowest).maxCoeff(), grid.frame.scale.minCoeff()));
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double scale = grid.frame.scale[axis];
    const double offset = grid.frame.offset[axis];
    grid.min[axis] = grid.steps(survey.front, survey.lowest, axis) * scale + offset;
    grid.max[axis] = grid.steps(survey.front, survey.highest, axis) * scale + offset;
  }
  return grid;
}

void put_text(ByteWriter* writer, const std::string& text, size_t size) {
  std::string padded = text;
  padded.resize(size, '\0');
  writer->put_bytes(padded.data(), size);
}

void put_zeros(ByteWriter* writer, size_t size) {
  for (size_t i = 0; i < size; ++i) writer->put<uint8_t>(0);
}

void put_record(ByteWriter* writer, const LasRecord& record) {
  writer->put<uint16_t>(0);
  put_text(writer, record.user_id, 16);
  writer->put<uint16_t>(record.record_id);
  writer->put<uint16_t>(static_cast<uint16_t>(record.content.size()));
  put_text(writer, record.description, 32);
  writer->put_bytes(reinterpret_cast<const char*>(record.content.data()), record.content.size());
}

LasRecord extra_bytes_record(const ExtraBytes& extra) {
  LasRecord record;
  record.user_id = "LASF_Spec";
  record.record_id = 4;
  record.description = "extra bytes";
  record.content = extra.entries;
  return record;
}

constexpr uint16_t kWktEncodingBit = 0x10;

/// Formats 0 to 3 (stamps +1, colour +2) are what every program reads. A coordinate system in WKT and more than 2^32 -
/// 1 points ask for the newer 6 (stamps) and 7 (stamps and colour).
int choose_point_format(const Survey& survey, const LasFrame& frame) {
  const bool is_new =
      (frame.global_encoding & kWktEncodingBit) != 0 || survey.num_points > std::numeric_limits<uint32_t>::max();
  if (is_new) return survey.has_colors ? 7 : 6;
  return (survey.has_stamps ? 1 : 0) + (survey.has_colors ? 2 : 0);
}

void put_header(uint64_t num_points, const Grid& grid, int point_format, size_t record_size,
                const std::vector<LasRecord>& records, ByteWriter* writer) {
  size_t points_offset = kHeaderSize;
  for (const LasRecord& record : records) points_offset += kRecordHeaderSize + record.content.size();
  const uint64_t legacy_count = point_format < 6 ? num_points : 0;
  writer->put_bytes("LASF", 4);
  writer->put<uint16_t>(0);
  writer->put<uint16_t>(grid.frame.global_encoding);
  put_zeros(writer, 16);
  writer->put<uint8_t>(1);
  writer->put<uint8_t>(4);
  put_text(writer, "EXTRACTION", 32);
  put_text(writer, "CP+", 32);
  put_zeros(writer, 4);
  writer->put<uint16_t>(kHeaderSize);
  writer->put<uint32_t>(static_cast<uint32_t>(points_offset));
  writer->put<uint32_t>(static_cast<uint32_t>(records.size()));
  writer->put<uint8_t>(static_cast<uint8_t>(point_format));
  writer->put<uint16_t>(static_cast<uint16_t>(record_size));
  writer->put<uint32_t>(static_cast<uint32_t>(legacy_count));
  writer->put<uint32_t>(static_cast<uint32_t>(legacy_count));  // all are first returns
  put_zeros(writer, 4 * sizeof(uint32_t));
  for (const double value : grid.frame.scale) writer->put(value);
  for (const double value : grid.frame.offset) writer->put(value);
  for (int axis = 0; axis < 3; ++axis) {
    writer->put(grid.max[axis]);
    writer->put(grid.min[axis]);
  }
  put_zeros(writer, sizeof(uint64_t) + sizeof(uint64_t) + sizeof(uint32_t));  // no waveforms, no extended records
  writer->put<uint64_t>(num_points);
  writer->put<uint64_t>(num_points);
  put_zeros(writer, 14 * sizeof(uint64_t));
  for (const LasRecord& record : records) put_record(writer, record);
}

void put_point(const PointCloud& cloud, const Grid& grid, int point_format, double intensity_factor, size_t i,
               ByteWriter* writer) {
  for (int axis = 0; axis < 3; ++axis) {
    writer->put(static_cast<int32_t>(grid.steps(cloud, cloud.positions[i], axis)));
  }
  writer->put<uint16_t>(cloud.intensities.empty() ? 0 : to_16_bits(cloud.intensities[i] * intensity_factor));
  const bool is_new = point_format >= 6;
  writer->put<uint8_t>(is_new ? 1 | 1 << 4 : 1 | 1 << 3);  // the first of one return
  put_zeros(writer, is_new ? 7 : 5);                       // flags, class, scan angle, user data, source
  if (!cloud.stamps_s.empty()) {
    writer->put(cloud.stamps_s[i]);
  } else if (is_new) {
    writer->put(0.0);
  }
  if (!cloud.colors.empty()) {
    constexpr uint16_t kToSixteenBits = 257;
    for (const uint8_t channel : cloud.colors[i])
      writer->put<uint16_t>(static_cast<uint16_t>(channel * kToSixteenBits));
  }
  if (!cloud.num_views.empty()) writer->put(cloud.num_views[i]);
  if (!cloud.best_images.empty()) writer->put(cloud.best_images[i]);
  if (!cloud.color_spreads.empty()) writer->put(cloud.color_spreads[i]);
}

}  // namespace

std::unique_ptr<CloudSource> open_las(const std::string& path) { return std::make_unique<LasSource>(path); }

void write_las(const std::string& path, const CloudStream& cloud) {
  const Survey survey = survey_points(path, cloud);
  const Grid grid = choose_grid(path, survey);
  const int point_format = choose_point_format(survey, grid.frame);
  std::vector<LasRecord> records = grid.frame.projection;
  if (survey.extra.size > 0) records.push_back(extra_bytes_record(survey.extra));
  AtomicFile file(path);
  ByteWriter writer(&file.stream());
  put_header(cloud.num_points, grid, point_format, las_record_size(point_format) + survey.extra.size, records, &writer);
  cloud.for_each_block([&](const PointCloud& block) {
    for (size_t i = 0; i < block.size(); ++i)
      put_point(block, grid, point_format, survey.intensity_factor.value(), i, &writer);
  });
  writer.flush();
  file.commit();
}

}  // namespace cpplus
