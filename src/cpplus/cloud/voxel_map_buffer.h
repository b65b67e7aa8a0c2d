#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>

namespace cpplus {

struct FreeBuffer {
  void operator()(void* data) const { std::free(data); }
};
/// An array as long as the cloud, not initialised: filling it twice would cost as much as a pass of sorting.
template <typename T>
using Buffer = std::unique_ptr<T[], FreeBuffer>;

/// Memory for `bytes`, on large pages where the system has them: a page fault every 4 KiB would cost a tenth of the
/// time of building a map. Throws std::bad_alloc.
void* allocate_buffer(size_t bytes);

template <typename T>
Buffer<T> make_buffer(size_t size) {
  T* data = static_cast<T*>(allocate_buffer(size * sizeof(T)));
  std::uninitialized_default_construct_n(data, size);  // nothing to do for numbers and for Eigen's fixed vectors
  return Buffer<T>(data);
}

}  // namespace cpplus
