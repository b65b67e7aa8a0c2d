#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace cpplus {

/// Decodes an LZ4 frame (the format of `lz4` files, version 1.x), such as the compressed chunks of ROS bags. Checksums
/// are not checked. `where` begins the messages of the Error for what is no whole frame, or decodes to more than
/// max_size bytes.
std::vector<uint8_t> decode_lz4_frame(const std::string& where, const uint8_t* data, size_t size, size_t max_size);

}  // namespace cpplus
