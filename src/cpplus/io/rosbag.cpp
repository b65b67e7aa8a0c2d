#include "cpplus/io/rosbag.h"

#include <fmt/format.h>

#include <cstring>
#include <map>
#include <string_view>

#include "cpplus/core/error.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/text_parse.h"

namespace cpplus {
namespace {

using Fields = std::map<std::string, std::string>;

enum Op : uint8_t {
  kMessage = 0x02,
  kHeader = 0x03,
  kIndex = 0x04,
  kChunk = 0x05,
  kChunkInfo = 0x06,
  kConnection = 0x07
};

template <typename T>
T load(const void* data) {
  T value;
  std::memcpy(&value, data, sizeof(T));
  return value;
}

/// "name=value" after its length, one after the other.
Fields parse_fields(const std::string& path, std::string_view bytes) {
  Fields fields;
  while (!bytes.empty()) {
    const uint32_t length = bytes.size() >= 4 ? load<uint32_t>(bytes.data()) : UINT32_MAX;
    if (length > bytes.size() - 4) throw Error(fmt::format("{}: a record's header is broken", path));
    const std::string_view field = bytes.substr(4, length);
    const size_t equals = field.find('=');
    if (equals == std::string_view::npos) throw Error(fmt::format("{}: a record's header is broken", path));
    fields[std::string(field.substr(0, equals))] = std::string(field.substr(equals + 1));
    bytes.remove_prefix(4 + length);
  }
  return fields;
}

template <typename T>
T number_of(const std::string& path, const Fields& fields, const char* name) {
  const auto found = fields.find(name);
  if (found == fields.end() || found->second.size() != sizeof(T)) {
    throw Error(fmt::format("{}: a record has no {}", path, name));
  }
  return load<T>(found->second.data());
}

struct Connection {
  std::string topic;
  std::string type;
};

class BagReader {
 public:
  explicit BagReader(const std::string& path) : reader_(path) {
    std::string_view line;
    if (!reader_.take_line(&line) || line != "#ROSBAG V2.0") {
      throw Error(fmt::format("{}: not a ROS 1 bag of format 2.0", path));
    }
  }

  void read(const std::function<void(const BagMessage&)>& take_message) {
    while (reader_.remaining() > 0) {
      const Fields fields = parse_fields(reader_.path(), take_bytes());
      switch (number_of<uint8_t>(reader_.path(), fields, "op")) {
        case kChunk:
          enter_chunk(fields);
          break;
        case kConnection:
          add_connection(fields);
          break;
        case kMessage:
          hand_out(fields, take_message);
          break;
        default:
          reader_.skip(take_length());
      }
    }
  }

 private:
  uint32_t take_length() {
    const uint32_t length = load<uint32_t>(reader_.take(4));
    if (length > reader_.remaining()) {
      throw Error(
          fmt::format("{}: truncated: {} bytes announced, {} left", reader_.path(), length, reader_.remaining()));
    }
    return length;
  }

  std::string_view take_bytes() {
    const uint32_t length = take_length();
    return {reinterpret_cast<const char*>(reader_.take(length)), length};
  }

  /// The records of a chunk that is not compressed simply follow.
  void enter_chunk(const Fields& fields) {
    const auto compression = fields.find("compression");
    if (compression == fields.end() || compression->second != "none") {
      throw Error(fmt::format("{}: its chunks are compressed ({}); `rosbag decompress` makes a bag that can be read",
                              reader_.path(), compression == fields.end() ? "?" : compression->second));
    }
    take_length();
  }

  void add_connection(const Fields& fields) {
    const uint32_t id = number_of<uint32_t>(reader_.path(), fields, "conn");
    const auto topic = fields.find("topic");
    const Fields details = parse_fields(reader_.path(), take_bytes());
    const auto type = details.find("type");
    if (topic == fields.end() || type == details.end())
      throw Error(fmt::format("{}: a connection is broken", reader_.path()));
    connections_[id] = {topic->second, type->second};
  }

  void hand_out(const Fields& fields, const std::function<void(const BagMessage&)>& take_message) {
    const auto connection = connections_.find(number_of<uint32_t>(reader_.path(), fields, "conn"));
    const std::string_view bytes = take_bytes();
    if (connection == connections_.end()) throw Error(fmt::format("{}: a message of no connection", reader_.path()));
    take_message({connection->second.topic, connection->second.type, reinterpret_cast<const uint8_t*>(bytes.data()),
                  bytes.size()});
  }

  BlockReader reader_;
  std::map<uint32_t, Connection> connections_;
};

}  // namespace

void read_bag(const std::string& path, const std::function<void(const BagMessage&)>& take_message) {
  BagReader(path).read(take_message);
}

}  // namespace cpplus
