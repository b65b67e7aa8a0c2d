#include "cpplus/core/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "cpplus/core/log.h"

namespace cpplus {

std::string progress_line(const std::string& label, size_t done, size_t total, int bar_width) {
  const double share = total == 0 ? 1.0 : std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
  const size_t width = static_cast<size_t>(bar_width);
  const size_t filled = static_cast<size_t>(share * static_cast<double>(width));
  std::string bar(filled, '=');
  if (filled < width) bar += '>';
  bar.resize(width, ' ');
  return fmt::format("{}  [{}]  {}/{}", label, bar, done, total);
}

Progress::Progress(std::string label, size_t total)
    : label_(std::move(label)), total_(total), visible_(!is_quiet() && isatty(STDERR_FILENO) == 1) {
  if (visible_) draw();
}

Progress::~Progress() {
  if (visible_) fmt::print(stderr, "\r\x1b[K");  // carriage return, clear to the end of the line
}

void Progress::advance(size_t count) {
  if (!visible_) return;
  const std::lock_guard lock(mutex_);
  done_ += count;
  if (std::chrono::steady_clock::now() - last_drawn_ > std::chrono::milliseconds(100)) draw();
}

void Progress::draw() {
  last_drawn_ = std::chrono::steady_clock::now();
  fmt::print(stderr, "\r{}\x1b[K", progress_line(label_, done_, total_));
  std::fflush(stderr);
}

}  // namespace cpplus
