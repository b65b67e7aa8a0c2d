#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cpplus/colorize/color_samples.h"
#include "cpplus/io/scratch_file.h"

namespace cpplus {

/// The colour samples of the points of a map by root, in a temporary file: 3 bytes a point and 8 a kept sample. Reading
/// is safe from several threads.
class SampleFile {
 public:
  /// `target`: file that the temporary is for (io/scratch_file.h).
  SampleFile(const std::string& target, size_t num_roots, int max_samples)
      : file_(target), max_samples_(max_samples), places_(num_roots) {}

  /// Adds a root, whose points are [begin, end) of these. Throws Error where it cannot be written.
  void add(uint32_t root, const ColorSamples& samples, size_t begin, size_t end);
  /// Those of the points of a root, in map order; of none where it was not added.
  ColorSamples read(uint32_t root) const;

 private:
  struct Place {
    uint64_t offset = 0;
    uint32_t num_points = 0;
    uint32_t num_samples = 0;
  };

  ScratchFile file_;
  int max_samples_;
  uint64_t end_ = 0;
  std::vector<Place> places_;  // by root
};

}  // namespace cpplus
