#include "cpplus/cloud/voxel_map_buffer.h"

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <new>

namespace cpplus {

void* allocate_buffer(size_t bytes) {
  constexpr size_t large_page = size_t{1} << 21;
  const bool is_large = bytes >= large_page;
  const size_t rounded = (bytes + large_page - 1) / large_page * large_page;
  void* data = is_large ? std::aligned_alloc(large_page, rounded) : std::malloc(bytes + 1);
  if (data == nullptr) throw std::bad_alloc();
#ifdef __linux__
  if (is_large) madvise(data, bytes, MADV_HUGEPAGE);  // only advice: where it is refused, small pages do
#endif
  return data;
}

}  // namespace cpplus
