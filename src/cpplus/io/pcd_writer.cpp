#include "cpplus/io/pcd_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <type_traits>
#include <vector>

#include "cpplus/core/error.h"
#include "cpplus/core/parallel.h"
#include "cpplus/io/pcd.h"

namespace cpplus {
namespace {

constexpr const char* kPackedColor = "rgb";

/// Calls visit(name, value_of) for each field of a cloud's records; value_of(i) is the value of point i.
template <typename Visit>
void for_each_field(const PointCloud& cloud, const Visit& visit) {
  constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    const char* name = kAxes[static_cast<size_t>(axis)];
    if (cloud.origin.isZero(0.0)) {
      visit(name, [&](size_t i) { return cloud.positions[i][axis]; });
    } else {
      visit(name, [&](size_t i) { return cloud.origin[axis] + static_cast<double>(cloud.positions[i][axis]); });
    }
  }
  const auto visit_values = [&](const char* name, const auto& values) {
    if (!values.empty()) visit(name, [&](size_t i) { return values[i]; });
  };
  visit_values("intensity", cloud.intensities);
  if (!cloud.colors.empty()) {
    visit(kPackedColor, [&](size_t i) {
      const Rgb& color = cloud.colors[i];
      return static_cast<uint32_t>(color[0]) << 16 | static_cast<uint32_t>(color[1]) << 8 | color[2];
    });
  }
  visit_values("timestamp", cloud.stamps_s);
  visit_values("num_views", cloud.num_views);
  visit_values("best_image", cloud.best_images);
  visit_values("color_spread", cloud.color_spreads);
}

void fill_records(const PointCloud& cloud, size_t first, size_t size, size_t record_size, char* records) {
  size_t offset = 0;
  for_each_field(cloud, [&](const char*, const auto& value_of) {
    for (size_t i = 0; i < size; ++i) {
      const auto value = value_of(first + i);
      std::memcpy(records + i * record_size + offset, &value, sizeof(value));
    }
    offset += sizeof(value_of(0));
  });
}

/// A batch of pieces is made by all threads and then written, so that memory does not grow with the cloud.
void write_records(const PointCloud& cloud, size_t record_size, std::ostream* stream) {
  constexpr size_t kPiece = 1 << 14;
  constexpr size_t kBatch = 8 * kPiece;
  std::vector<char> records(std::min(kBatch, cloud.size()) * record_size);
  for (size_t first = 0; first < cloud.size(); first += kBatch) {
    const size_t size = std::min(kBatch, cloud.size() - first);
    parallel_for_chunks(size, kPiece, [&](size_t begin, size_t end) {
      fill_records(cloud, first + begin, end - begin, record_size, &records[begin * record_size]);
    });
    stream->write(records.data(), static_cast<std::streamsize>(size * record_size));
  }
}

/// `block`: some of the points.
PcdLayout layout_of(const PointCloud& block) {
  PcdLayout layout;
  for_each_field(block, [&](const char* name, const auto& value_of) {
    using Value = decltype(value_of(0));
    layout.fields += fmt::format(" {}", name);
    layout.sizes += fmt::format(" {}", sizeof(Value));
    // Packed colours are called a float, as PCL does.
    layout.types += std::is_floating_point_v<Value> || name == kPackedColor ? " F" : " U";
    layout.counts += " 1";
    layout.record_size += sizeof(Value);
  });
  return layout;
}

/// `padding`: of the first line, which is a comment.
std::string header_text(const PcdLayout& layout, size_t num_points, size_t padding = 0) {
  return fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format{}\nVERSION 0.7\nFIELDS{}\nSIZE{}\nTYPE{}\nCOUNT{}\nWIDTH {}\n"
      "HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      std::string(padding, ' '), layout.fields, layout.sizes, layout.types, layout.counts, num_points, num_points);
}

/// Longer than any header that is to take its place.
std::string room_for_header(const PcdLayout& layout) { return header_text(layout, std::numeric_limits<size_t>::max()); }

}  // namespace

PcdWriter::PcdWriter(const std::string& path) : file_(path) {}

void PcdWriter::add(const PointCloud& block) {
  if (block.empty()) return;
  if (!layout_) {
    layout_ = layout_of(block);
    file_.stream() << room_for_header(*layout_);
  }
  write_records(block, layout_->record_size, &file_.stream());
  if (!file_.stream()) throw Error(fmt::format("{}: cannot write all of it: {}", file_.path(), std::strerror(errno)));
  num_points_ += block.size();
}

void PcdWriter::commit() {
  if (!layout_) layout_ = layout_of({});
  const size_t padding = room_for_header(*layout_).size() - header_text(*layout_, num_points_).size();
  file_.stream().seekp(0);
  file_.stream() << header_text(*layout_, num_points_, padding);
  file_.commit();
}

void write_pcd(const std::string& path, const CloudStream& cloud) {
  AtomicFile file(path);
  size_t record_size = 0;  // 0 before the header is written
  cloud.for_each_block([&](const PointCloud& block) {
    if (record_size == 0) {
      const PcdLayout layout = layout_of(block);
      file.stream() << header_text(layout, cloud.num_points);
      record_size = layout.record_size;
    }
    write_records(block, record_size, &file.stream());
  });
  file.commit();
}

}  // namespace cpplus
