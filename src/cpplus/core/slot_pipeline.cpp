#include "cpplus/core/slot_pipeline.h"

#include <tbb/parallel_pipeline.h>

#include <limits>
#include <mutex>
#include <vector>

#include "cpplus/core/first_failure.h"
#include "cpplus/core/interrupt.h"

namespace cpplus {
namespace {

class SlotPipeline {
 public:
  SlotPipeline(size_t num_slots, const PipelineStages& stages)
      : stages_(stages), failure_(std::numeric_limits<size_t>::max()) {
    for (size_t slot = num_slots; slot > 0; --slot) free_.push_back(slot - 1);
  }

  void run() {
    const auto serial = tbb::filter_mode::serial_in_order;
    const auto parallel = tbb::filter_mode::parallel;
    const size_t num_slots = free_.size();
    tbb::parallel_pipeline(
        num_slots, tbb::make_filter<void, Item>(serial, [this](tbb::flow_control& control) { return take(control); }) &
                       tbb::make_filter<Item, Item>(parallel, [this](Item item) { return go(stages_.work, item); }) &
                       tbb::make_filter<Item, Item>(serial, [this](Item item) { return go(stages_.put, item); }) &
                       tbb::make_filter<Item, void>(parallel, [this](Item item) { finish(item); }));
    failure_.rethrow();
  }

 private:
  struct Item {
    size_t index = 0;
    size_t slot = 0;
  };

  Item take(tbb::flow_control& control) {
    const Item item{num_taken_++, pop_slot()};
    bool is_taken = false;
    if (failure_.index() == std::numeric_limits<size_t>::max()) {
      try {
        check_interrupt();
        is_taken = stages_.take(item.slot);
      } catch (...) {
        failure_.add(item.index);
      }
    }
    if (!is_taken) control.stop();
    return item;
  }

  Item go(const std::function<void(size_t slot)>& stage, Item item) {
    if (failure_.index() <= item.index) return item;
    try {
      stage(item.slot);
    } catch (...) {
      failure_.add(item.index);
    }
    return item;
  }

  void finish(Item item) {
    if (stages_.finish) go(stages_.finish, item);
    const std::lock_guard lock(mutex_);
    free_.push_back(item.slot);
  }

  size_t pop_slot() {
    const std::lock_guard lock(mutex_);
    const size_t slot = free_.back();  // there is one: no more items than slots are in work
    free_.pop_back();
    return slot;
  }

  const PipelineStages& stages_;
  FirstFailure failure_;
  std::mutex mutex_;
  std::vector<size_t> free_;
  size_t num_taken_ = 0;
};

}  // namespace

void run_slot_pipeline(size_t num_slots, const PipelineStages& stages) { SlotPipeline(num_slots, stages).run(); }

}  // namespace cpplus
