#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace cpplus {

/// A message of a bag; what it points to is valid during the call.
struct BagMessage {
  const std::string& topic;
  const std::string& type;  // "sensor_msgs/Image"
  const uint8_t* data;
  size_t size;
};

/// Reads a ROS 1 bag (format 2.0) from front to back and hands out its messages in the order of the file. Throws Error
/// for another kind of file, a record that is broken off, and compressed chunks.
void read_bag(const std::string& path, const std::function<void(const BagMessage&)>& take_message);

}  // namespace cpplus
