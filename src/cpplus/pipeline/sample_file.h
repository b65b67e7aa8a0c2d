#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cpplus/colorize/color_samples.h"
#include "cpplus/io/scratch_file.h"

namespace cpplus {

/// The colour samples of the parts of a map in a temporary file: 3 bytes a point and 8 a kept sample.
class SampleFile {
 public:
  /// `target`: file that the temporary is for (io/scratch_file.h).
  SampleFile(const std::string& target, int max_samples) : file_(target), max_samples_(max_samples) {}

  /// Adds the next part. Throws Error where it cannot be written.
  void add(const ColorSamples& samples);
  ColorSamples read(size_t part) const;

 private:
  struct Part {
    uint64_t offset = 0;
    size_t num_points = 0;
  };

  ScratchFile file_;
  int max_samples_;
  uint64_t end_ = 0;
  std::vector<Part> parts_;
};

}  // namespace cpplus
