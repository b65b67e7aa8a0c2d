#include "cpplus/pipeline/sample_file.h"

#include <cstring>
#include <span>

namespace cpplus {
namespace {

template <typename T>
void append(const T* values, size_t count, std::vector<char>* bytes) {
  const auto* begin = reinterpret_cast<const char*>(values);
  bytes->insert(bytes->end(), begin, begin + count * sizeof(T));
}

/// The next of these bytes as values, and moves on.
template <typename T>
void take(const char** next, size_t count, T* values) {
  if (count > 0) std::memcpy(values, *next, count * sizeof(T));
  *next += count * sizeof(T);
}

/// Of each point: how many images showed it (uint16), how many samples follow (uint8), and these.
constexpr size_t kCountBytes = 3;

}  // namespace

void SampleFile::add(uint32_t root, const ColorSamples& samples, size_t begin, size_t end) {
  Place place{end_, static_cast<uint32_t>(end - begin), 0};
  std::vector<char> bytes;
  for (size_t point = begin; point < end; ++point) {
    const std::span<const ColorSample> kept = samples.of_point(point);
    const uint16_t num_views = samples.num_views(point);
    const auto num_kept = static_cast<uint8_t>(kept.size());
    append(&num_views, 1, &bytes);
    append(&num_kept, 1, &bytes);
    append(kept.data(), kept.size(), &bytes);
    place.num_samples += static_cast<uint32_t>(kept.size());
  }
  file_.write(end_, bytes.data(), bytes.size());
  end_ += bytes.size();
  places_[root] = place;
}

ColorSamples SampleFile::read(uint32_t root) const {
  const Place& place = places_[root];
  std::vector<char> bytes(kCountBytes * place.num_points + sizeof(ColorSample) * place.num_samples);
  file_.read(place.offset, bytes.data(), bytes.size());
  ColorSamples samples(place.num_points, max_samples_);
  const char* next = bytes.data();
  std::vector<ColorSample> kept;
  for (size_t point = 0; point < place.num_points; ++point) {
    uint16_t num_views = 0;
    uint8_t num_kept = 0;
    take(&next, 1, &num_views);
    take(&next, 1, &num_kept);
    kept.resize(num_kept);
    take(&next, num_kept, kept.data());
    samples.restore(point, kept, num_views);
  }
  return samples;
}

}  // namespace cpplus
