#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>

namespace cpplus {

/// "label  [=====>    ]  12/30  4.0/s  5 s left": one line of a progress bar, `bar_width` characters between the
/// brackets. Rate and time left are there once something is done; `seconds` is the time since the start.
std::string progress_line(const std::string& label, size_t done, size_t total, double seconds, int bar_width = 30);

/// The same for other programs, one JSON object: {"stage": "refine", "done": 12, "total": 30, "per_second": 4,
/// "seconds_left": 4.5}, the last two null until something is done.
std::string progress_json(const std::string& label, size_t done, size_t total, double seconds);

/// With JSON progress on, every stage writes a line of progress_json() to stderr, terminal or not: at its start, at
/// most twice a second, and at its end. Off at the start.
void set_json_progress(bool json);

/// A progress bar on stderr, drawn only where stderr is a terminal and the program is not quiet (core/log.h), at most
/// ten times a second; the line is cleared at the end. advance() may be called from several threads.
class Progress {
 public:
  Progress(std::string label, size_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void advance(size_t count = 1);

 private:
  void draw();

  std::string label_;
  size_t total_;
  bool json_;
  bool visible_;  // the bar
  std::mutex mutex_;
  size_t done_ = 0;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point last_drawn_;
};

}  // namespace cpplus
