#pragma once

namespace cpplus {

/// Gives memory that was freed back to the system, where the C library can. Many small arrays leave holes that no large
/// one fits in, and which count as the program's until then. Takes a few milliseconds.
void return_freed_memory();

}  // namespace cpplus
