#pragma once

namespace cpplus {

/// The arrays of a PointCloud besides its positions: which ones there are.
struct PointAttributes {
  bool intensities = true;
  bool colors = true;
  bool stamps_s = true;
  bool num_views = true;
  bool best_images = true;
  bool color_spreads = true;

  /// Calls visit(array, other's array) for the positions of two clouds and each attribute that there is.
  template <typename Cloud, typename OtherCloud, typename Visit>
  void for_each_array(Cloud& cloud, OtherCloud& other, const Visit& visit) const {
    visit(cloud.positions, other.positions);
    if (intensities) visit(cloud.intensities, other.intensities);
    if (colors) visit(cloud.colors, other.colors);
    if (stamps_s) visit(cloud.stamps_s, other.stamps_s);
    if (num_views) visit(cloud.num_views, other.num_views);
    if (best_images) visit(cloud.best_images, other.best_images);
    if (color_spreads) visit(cloud.color_spreads, other.color_spreads);
  }
};

}  // namespace cpplus
