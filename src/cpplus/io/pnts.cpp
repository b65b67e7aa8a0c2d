#include "cpplus/io/pnts.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

namespace cpplus {
namespace {

constexpr double kSteps = 65535.0;
constexpr size_t kHeaderSize = 28;
constexpr size_t kAlignment = 8;

template <typename Number>
void append(Number value, std::string* bytes) {
  char raw[sizeof(Number)];
  std::memcpy(raw, &value, sizeof(Number));
  bytes->append(raw, sizeof(Number));
}

void pad(char with, size_t size_before, std::string* bytes) {
  while ((size_before + bytes->size()) % kAlignment != 0) bytes->push_back(with);
}

nlohmann::ordered_json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

std::string encode_pnts(std::span<const Eigen::Vector3d> positions, std::span<const Rgb> colors) {
  assert(!positions.empty() && positions.size() == colors.size());
  Eigen::Vector3d low = positions.front(), high = positions.front();
  for (const Eigen::Vector3d& x : positions) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const Eigen::Vector3d extent = (high - low).cwiseMax(1e-6);
  nlohmann::ordered_json table;
  table["POINTS_LENGTH"] = positions.size();
  table["QUANTIZED_VOLUME_OFFSET"] = vector_json(low);
  table["QUANTIZED_VOLUME_SCALE"] = vector_json(extent);
  table["POSITION_QUANTIZED"] = {{"byteOffset", 0}};
  table["RGB"] = {{"byteOffset", positions.size() * 3 * sizeof(uint16_t)}};
  std::string json = table.dump();
  pad(' ', kHeaderSize, &json);

  std::string binary;
  binary.reserve(positions.size() * 9 + kAlignment);
  for (const Eigen::Vector3d& x : positions) {
    const Eigen::Vector3d steps = (x - low).cwiseQuotient(extent) * kSteps;
    for (int i = 0; i < 3; ++i) append(static_cast<uint16_t>(std::clamp(std::lround(steps[i]), 0L, 65535L)), &binary);
  }
  for (const Rgb& color : colors) binary.append(reinterpret_cast<const char*>(color.data()), color.size());
  pad('\0', 0, &binary);

  std::string bytes = "pnts";
  append(uint32_t{1}, &bytes);
  append(static_cast<uint32_t>(kHeaderSize + json.size() + binary.size()), &bytes);
  append(static_cast<uint32_t>(json.size()), &bytes);
  append(static_cast<uint32_t>(binary.size()), &bytes);
  append(uint32_t{0}, &bytes);  // no batch table
  append(uint32_t{0}, &bytes);
  return bytes + json + binary;
}

}  // namespace cpplus
