#pragma once

#include <cstddef>
#include <functional>

namespace cpplus {

/// What becomes of items that come one after the other, each in a slot that the next one reuses: what a slot owns
/// bounds the memory, and need not be made anew.
struct PipelineStages {
  /// Puts the next item into the slot; false where there is none any more. One item at a time, in order.
  std::function<bool(size_t slot)> take;
  /// Several items at a time.
  std::function<void(size_t slot)> work;
  /// One item at a time, in the order of taking.
  std::function<void(size_t slot)> put;
  /// Several items at a time, in any order. May be left out.
  std::function<void(size_t slot)> finish;
};

/// Runs all items through the stages, at most num_slots of them at a time, in slots [0, num_slots). What `put` does is
/// the same for any number of threads. Where stages throw, no item behind the one that failed is put any more, and the
/// exception of the first such item is rethrown once the others have left. Throws Interrupted in place of taking the
/// next item once a stop was asked for (core/interrupt.h).
void run_slot_pipeline(size_t num_slots, const PipelineStages& stages);

}  // namespace cpplus
