#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "cpplus/io/test_files.h"

/// Makes ROS 1 bags for tests.
namespace cpplus::testing_bag {

inline std::string text(const std::string& bytes) { return bytes_of(static_cast<uint32_t>(bytes.size())) + bytes; }

inline std::string field(const std::string& name, const std::string& value) { return text(name + "=" + value); }

inline std::string record(const std::string& fields, const std::string& data) { return text(fields) + text(data); }

inline std::string op(uint8_t code) { return field("op", bytes_of(code)); }

inline std::string header(double stamp_s, const std::string& frame) {
  const uint32_t seconds = static_cast<uint32_t>(stamp_s);
  const uint32_t nanoseconds = static_cast<uint32_t>(1e9 * (stamp_s - seconds) + 0.5);
  return bytes_of(uint32_t{7}) + bytes_of(seconds) + bytes_of(nanoseconds) + text(frame);
}

/// The bytes of a bag whose messages are in one chunk.
class BagBuilder {
 public:
  void add(const std::string& topic, const std::string& type, const std::string& message) {
    if (ids_.count(topic) == 0) {
      const uint32_t id = static_cast<uint32_t>(ids_.size());
      ids_[topic] = id;
      chunk_ +=
          record(op(0x07) + field("conn", bytes_of(id)) + field("topic", topic),
                 field("topic", topic) + field("type", type) + field("md5sum", "*") + field("message_definition", ""));
    }
    chunk_ += record(op(0x02) + field("conn", bytes_of(ids_[topic])) + field("time", bytes_of(uint64_t{0})), message);
  }

  std::string bytes(const std::string& compression = "none") const { return bag_of(compression, chunk_); }

  /// The chunk as an LZ4 frame whose one block is stored as it is.
  std::string lz4_bytes() const {
    const std::string head("\x04\x22\x4d\x18\x60\x70\x00", 7);
    const std::string block_size = bytes_of(static_cast<uint32_t>(chunk_.size()) | 0x80000000u);
    return bag_of("lz4", head + block_size + chunk_ + std::string(4, '\0'));
  }

 private:
  std::string bag_of(const std::string& compression, const std::string& data) const {
    const std::string size = bytes_of(static_cast<uint32_t>(chunk_.size()));
    return "#ROSBAG V2.0\n" + record(op(0x03) + field("index_pos", bytes_of(uint64_t{0})), std::string(60, ' ')) +
           record(op(0x05) + field("compression", compression) + field("size", size), data) +
           record(op(0x04) + field("ver", bytes_of(uint32_t{1})), "index");
  }

  std::string chunk_;
  std::map<std::string, uint32_t> ids_;
};

inline std::string odometry(double stamp_s, double x) {
  std::string message = header(stamp_s, "map") + text("base");
  // A quarter turn to the left.
  for (const double value : {x, 2.0, 3.0, 0.0, 0.0, 0.70710678118654752, 0.70710678118654752})
    message += bytes_of(value);
  return message + std::string(8 * (36 + 6 + 36), '\0');  // covariance and twist
}

inline std::string image(double stamp_s, const std::string& encoding, const std::string& pixels) {
  return header(stamp_s, "camera") + bytes_of(uint32_t{1}) + bytes_of(uint32_t{2}) + text(encoding) +
         std::string(1, '\0') + bytes_of(static_cast<uint32_t>(pixels.size())) + text(pixels);
}

}  // namespace cpplus::testing_bag
