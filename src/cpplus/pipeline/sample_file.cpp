#include "cpplus/pipeline/sample_file.h"

#include <algorithm>
#include <span>

namespace cpplus {
namespace {

/// Points whose samples are written or read at a time.
constexpr size_t kBlockPoints = size_t{1} << 16;

/// Of some points: how many views they have, how many samples, and these.
struct Block {
  std::vector<uint16_t> num_views;
  std::vector<uint8_t> num_kept;
  std::vector<ColorSample> samples;

  Block(const ColorSamples& from, size_t begin, size_t end) {
    for (size_t point = begin; point < end; ++point) {
      const std::span<const ColorSample> kept = from.of_point(point);
      num_views.push_back(from.num_views(point));
      num_kept.push_back(static_cast<uint8_t>(kept.size()));
      samples.insert(samples.end(), kept.begin(), kept.end());
    }
  }
  explicit Block(size_t num_points) : num_views(num_points), num_kept(num_points) {}

  void restore(size_t begin, ColorSamples* to) const {
    size_t next = 0;
    for (size_t k = 0; k < num_kept.size(); ++k) {
      to->restore(begin + k, std::span(samples).subspan(next, num_kept[k]), num_views[k]);
      next += num_kept[k];
    }
  }
  size_t num_samples() const {
    size_t sum = 0;
    for (const uint8_t kept : num_kept) sum += kept;
    return sum;
  }
};

template <typename T>
size_t size_in_bytes(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

}  // namespace

void SampleFile::add(const ColorSamples& samples) {
  parts_.push_back({end_, samples.num_points()});
  const auto write = [&](const auto& values) {
    file_.write(end_, values.data(), size_in_bytes(values));
    end_ += size_in_bytes(values);
  };
  for (size_t begin = 0; begin < samples.num_points(); begin += kBlockPoints) {
    const Block block(samples, begin, std::min(begin + kBlockPoints, samples.num_points()));
    write(block.num_views);
    write(block.num_kept);
    write(block.samples);
  }
}

ColorSamples SampleFile::read(size_t part) const {
  const size_t num_points = parts_[part].num_points;
  ColorSamples samples(num_points, max_samples_);
  uint64_t offset = parts_[part].offset;
  const auto read = [&](auto* values) {
    file_.read(offset, values->data(), size_in_bytes(*values));
    offset += size_in_bytes(*values);
  };
  for (size_t begin = 0; begin < num_points; begin += kBlockPoints) {
    Block block(std::min(kBlockPoints, num_points - begin));
    read(&block.num_views);
    read(&block.num_kept);
    block.samples.resize(block.num_samples());
    read(&block.samples);
    block.restore(begin, &samples);
  }
  return samples;
}

}  // namespace cpplus
