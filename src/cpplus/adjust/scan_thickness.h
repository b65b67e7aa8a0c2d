#pragma once

#include <cstddef>
#include <vector>

#include "cpplus/adjust/scan_patches.h"
#include "cpplus/geometry/rigid3.h"

namespace cpplus {

/// How thick the planes of a map are: RMS distance of the points of all scans from the plane that fits them best.
struct ThicknessChange {
  size_t num_patches = 0;
  double before_m = 0.0;
  double after_m = 0.0;
  /// The same of the points of one scan alone: what no pose can take away.
  double single_scan_m = 0.0;
  /// Decrease of the mean squared thickness as a share of it, and the standard deviation of that figure.
  double gain = 0.0;
  double gain_sigma = 0.0;
};

/// Thickness of the patches before and after each scan was moved. Patches that are three times as thick as the median
/// are left out, by their thickness before: it is the state before that this choice flatters.
ThicknessChange measure_thickness(const std::vector<ScanPatch>& patches, const std::vector<Rigid3>& new_map_from_map);

}  // namespace cpplus
