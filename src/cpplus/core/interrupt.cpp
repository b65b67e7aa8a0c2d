#include "cpplus/core/interrupt.h"

#include <atomic>
#include <csignal>

namespace cpplus {
namespace {

std::atomic<bool> requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler writes it");

extern "C" void ask_to_stop(int) { request_interrupt(); }

}  // namespace

void request_interrupt() noexcept { requested = true; }
bool interrupt_requested() noexcept { return requested; }
void clear_interrupt() noexcept { requested = false; }

void check_interrupt() {
  if (requested) throw Interrupted();
}

void stop_on_signals() {
  struct sigaction action = {};
  action.sa_handler = ask_to_stop;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
}

}  // namespace cpplus
