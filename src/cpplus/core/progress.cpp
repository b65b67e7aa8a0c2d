#include "cpplus/core/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <optional>

#include "cpplus/core/log.h"

namespace cpplus {

namespace {

std::atomic<bool> json_progress{false};

std::optional<double> rate_of(size_t done, double seconds) {
  if (done == 0 || !(seconds > 0.0)) return std::nullopt;
  return static_cast<double>(done) / seconds;
}

double seconds_left(size_t done, size_t total, double rate) {
  return static_cast<double>(total - std::min(done, total)) / rate;
}

std::string duration(double seconds) {
  const long s = std::lround(seconds);
  if (s < 90) return fmt::format("{} s", s);
  if (s < 90 * 60) return fmt::format("{} min", (s + 30) / 60);
  return fmt::format("{:.1f} h", seconds / 3600.0);
}

}  // namespace

std::string progress_line(const std::string& label, size_t done, size_t total, double seconds, int bar_width) {
  const double share = total == 0 ? 1.0 : std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
  const size_t width = static_cast<size_t>(bar_width);
  const size_t filled = static_cast<size_t>(share * static_cast<double>(width));
  std::string bar(filled, '=');
  if (filled < width) bar += '>';
  bar.resize(width, ' ');
  std::string line = fmt::format("{}  [{}]  {}/{}", label, bar, done, total);
  if (const auto rate = rate_of(done, seconds)) {
    line += fmt::format("  {:.1f}/s  {} left", *rate, duration(seconds_left(done, total, *rate)));
  }
  return line;
}

std::string progress_json(const std::string& label, size_t done, size_t total, double seconds) {
  const auto rate = rate_of(done, seconds);
  return fmt::format(R"({{"stage": "{}", "done": {}, "total": {}, "per_second": {}, "seconds_left": {}}})", label, done,
                     total, rate ? fmt::format("{:.3g}", *rate) : "null",
                     rate ? fmt::format("{:.3g}", seconds_left(done, total, *rate)) : "null");
}

void set_json_progress(bool json) { json_progress = json; }

Progress::Progress(std::string label, size_t total)
    : label_(std::move(label)),
      total_(total),
      json_(json_progress),
      visible_(!json_ && !is_quiet() && isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()) {
  if (visible_ || json_) draw();
}

Progress::~Progress() {
  if (json_) draw();
  if (visible_) fmt::print(stderr, "\r\x1b[K");  // carriage return, clear to the end of the line
}

void Progress::advance(size_t count) {
  if (!visible_ && !json_) return;
  const std::lock_guard lock(mutex_);
  done_ += count;
  const auto pause = std::chrono::milliseconds(json_ ? 500 : 100);
  if (std::chrono::steady_clock::now() - last_drawn_ > pause) draw();
}

void Progress::draw() {
  last_drawn_ = std::chrono::steady_clock::now();
  const double seconds = std::chrono::duration<double>(last_drawn_ - start_).count();
  if (json_) {
    fmt::print(stderr, "{}\n", progress_json(label_, done_, total_, seconds));
  } else {
    fmt::print(stderr, "\r{}\x1b[K", progress_line(label_, done_, total_, seconds));
  }
  std::fflush(stderr);
}

}  // namespace cpplus
