#include "cpplus/io/las_frame_bytes.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <string>
#include <type_traits>

namespace cpplus {
namespace {

template <typename T>
void put(T value, std::vector<uint8_t>* bytes) {
  static_assert(std::is_arithmetic_v<T>);
  const auto* data = reinterpret_cast<const uint8_t*>(&value);
  std::copy(data, data + sizeof(T), std::back_inserter(*bytes));
}

template <typename Container>
void put_list(const Container& list, std::vector<uint8_t>* bytes) {
  put(static_cast<uint32_t>(list.size()), bytes);
  std::copy(list.begin(), list.end(), std::back_inserter(*bytes));
}

/// Takes values from the front; good() is false once one was not there.
class Parser {
 public:
  explicit Parser(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  bool good() const { return good_; }
  bool at_end() const { return bytes_.empty(); }

  template <typename T>
  T take() {
    T value{};
    good_ = good_ && bytes_.size() >= sizeof(T);
    if (!good_) return value;
    std::memcpy(&value, bytes_.data(), sizeof(T));
    bytes_ = bytes_.subspan(sizeof(T));
    return value;
  }

  template <typename Container>
  Container take_list() {
    const size_t size = take<uint32_t>();
    good_ = good_ && bytes_.size() >= size;
    if (!good_) return {};
    const auto end = bytes_.begin() + static_cast<std::ptrdiff_t>(size);
    Container list(bytes_.begin(), end);
    bytes_ = bytes_.subspan(size);
    return list;
  }

 private:
  std::span<const uint8_t> bytes_;
  bool good_ = true;
};

}  // namespace

std::vector<uint8_t> las_frame_bytes(const LasFrame& frame) {
  std::vector<uint8_t> bytes;
  for (const double value : frame.scale) put(value, &bytes);
  for (const double value : frame.offset) put(value, &bytes);
  put(frame.global_encoding, &bytes);
  put(static_cast<uint32_t>(frame.projection.size()), &bytes);
  for (const LasRecord& record : frame.projection) {
    put_list(record.user_id, &bytes);
    put_list(record.description, &bytes);
    put(record.record_id, &bytes);
    put_list(record.content, &bytes);
  }
  return bytes;
}

std::optional<LasFrame> parse_las_frame(std::span<const uint8_t> bytes) {
  Parser parser(bytes);
  LasFrame frame;
  for (double& value : frame.scale) value = parser.take<double>();
  for (double& value : frame.offset) value = parser.take<double>();
  frame.global_encoding = parser.take<uint16_t>();
  const size_t num_records = parser.take<uint32_t>();
  for (size_t i = 0; i < num_records && parser.good(); ++i) {
    LasRecord record;
    record.user_id = parser.take_list<std::string>();
    record.description = parser.take_list<std::string>();
    record.record_id = parser.take<uint16_t>();
    record.content = parser.take_list<std::vector<uint8_t>>();
    frame.projection.push_back(std::move(record));
  }
  if (!parser.good() || !parser.at_end()) return std::nullopt;
  return frame;
}

}  // namespace cpplus
