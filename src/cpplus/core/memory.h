#pragma once

namespace cpplus {

/// Gives memory that was freed back to the system, where the C library can. Many small arrays leave holes that no large
/// one fits in, and which count as the program's until then. Takes a few milliseconds.
void return_freed_memory();

/// Frees what a vector holds, which assigning {} to it does not: that is a list of no elements, for which the memory
/// stays.
template <typename Vector>
void free_memory(Vector* vector) {
  Vector().swap(*vector);
}

}  // namespace cpplus
