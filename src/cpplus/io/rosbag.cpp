#include "cpplus/io/rosbag.h"

#include <fmt/format.h>

#include <cstring>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "cpplus/core/error.h"
#include "cpplus/io/block_reader.h"
#include "cpplus/io/lz4.h"

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
    const bool has_length = bytes.size() >= 4;
    const uint32_t length = has_length ? load<uint32_t>(bytes.data()) : 0;
    if (!has_length || length > bytes.size() - 4) throw Error(fmt::format("{}: a record's header is broken", path));
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

/// The records of a chunk that was decoded into memory, read as those of a file are.
class MemoryReader {
 public:
  MemoryReader(const std::string& path, std::vector<uint8_t> bytes) : path_(path), bytes_(std::move(bytes)) {}

  uint64_t remaining() const { return bytes_.size() - at_; }
  const uint8_t* take(size_t size) {
    if (size > remaining()) throw Error(fmt::format("{}: a chunk is broken off", path_));
    at_ += size;
    return bytes_.data() + at_ - size;
  }
  void skip(uint64_t size) { take(size); }

 private:
  const std::string& path_;
  std::vector<uint8_t> bytes_;
  size_t at_ = 0;
};

class BagReader {
 public:
  BagReader(const std::string& path, const std::function<void(const BagMessage&)>& take_message)
      : path_(path), take_message_(take_message) {}

  void read() {
    BlockReader file(path_);
    std::string_view line;
    if (!file.take_line(&line) || line != "#ROSBAG V2.0") {
      throw Error(fmt::format("{}: not a ROS 1 bag of format 2.0", path_));
    }
    read_records(&file);
  }

 private:
  template <typename Reader>
  void read_records(Reader* reader) {
    while (reader->remaining() > 0) {
      const Fields fields = parse_fields(path_, take_bytes(reader));
      switch (number_of<uint8_t>(path_, fields, "op")) {
        case kChunk:
          enter_chunk(fields, reader);
          break;
        case kConnection:
          add_connection(fields, take_bytes(reader));
          break;
        case kMessage:
          hand_out(fields, take_bytes(reader));
          break;
        default:
          reader->skip(take_length(reader));
      }
    }
  }

  template <typename Reader>
  uint32_t take_length(Reader* reader) {
    const uint32_t length = load<uint32_t>(reader->take(4));
    if (length > reader->remaining()) {
      throw Error(fmt::format("{}: truncated: {} bytes announced, {} left", path_, length, reader->remaining()));
    }
    return length;
  }

  template <typename Reader>
  std::string_view take_bytes(Reader* reader) {
    const uint32_t length = take_length(reader);
    return {reinterpret_cast<const char*>(reader->take(length)), length};
  }

  template <typename Reader>
  void enter_chunk(const Fields& fields, Reader* reader) {
    const auto found = fields.find("compression");
    const std::string compression = found == fields.end() ? "?" : found->second;
    if (compression == "none") {
      take_length(reader);  // its records simply follow
    } else if (compression == "lz4") {
      const std::string_view bytes = take_bytes(reader);
      MemoryReader chunk(path_, decode_lz4_frame(path_, reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size(),
                                                 number_of<uint32_t>(path_, fields, "size")));
      if (++depth_ > 1) throw Error(fmt::format("{}: a chunk inside a chunk", path_));
      read_records(&chunk);
      --depth_;
    } else {
      throw Error(fmt::format("{}: its chunks are compressed ({}); `rosbag decompress` makes a bag that can be read",
                              path_, compression));
    }
  }

  void add_connection(const Fields& fields, std::string_view data) {
    const uint32_t id = number_of<uint32_t>(path_, fields, "conn");
    const auto topic = fields.find("topic");
    const Fields details = parse_fields(path_, data);
    const auto type = details.find("type");
    if (topic == fields.end() || type == details.end()) throw Error(fmt::format("{}: a connection is broken", path_));
    connections_[id] = {topic->second, type->second};
  }

  void hand_out(const Fields& fields, std::string_view data) {
    const auto connection = connections_.find(number_of<uint32_t>(path_, fields, "conn"));
    if (connection == connections_.end()) throw Error(fmt::format("{}: a message of no connection", path_));
    take_message_({connection->second.topic, connection->second.type, reinterpret_cast<const uint8_t*>(data.data()),
                   data.size()});
  }

  const std::string& path_;
  const std::function<void(const BagMessage&)>& take_message_;
  std::map<uint32_t, Connection> connections_;
  int depth_ = 0;  // chunks that are decoded at the moment
};

}  // namespace

void read_bag(const std::string& path, const std::function<void(const BagMessage&)>& take_message) {
  BagReader(path, take_message).read();
}

}  // namespace cpplus
