#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>

namespace cpplus {

/// "label  [=====>    ]  12/30": one line of a progress bar, `bar_width` characters between the brackets.
std::string progress_line(const std::string& label, size_t done, size_t total, int bar_width = 30);

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
  bool visible_;
  std::mutex mutex_;
  size_t done_ = 0;
  std::chrono::steady_clock::time_point last_drawn_;
};

}  // namespace cpplus
