#pragma once

#include <string>
#include <vector>

#include "cpplus/geometry/sparse_model.h"

namespace cpplus {

/// How a folder of images and a model fit together.
struct ImageFolder {
  std::vector<size_t> with_file;          // indices into model.images whose file exists, in the model's order
  std::vector<size_t> missing;            // indices of the others
  std::vector<std::string> without_pose;  // image files in the folder that the model does not name, sorted
};

/// Looks for the images of the model below the folder (names may hold sub-folders). Throws Error when `directory` is
/// not a folder, or holds none of the model's images.
ImageFolder find_images(const std::string& directory, const SparseModel& model);

/// Whether the name ends as image files do (.jpg .png ..., any case).
bool has_image_extension(const std::string& path);

/// The image files below a folder, relative to it, sorted.
std::vector<std::string> list_images(const std::string& directory);

/// "DIR/NAME".
std::string image_path(const std::string& directory, const std::string& name);

/// "left/a.jpg" -> "left_a.png": the name of a picture made for an image, all in one folder.
std::string debug_image_name(const std::string& name);

/// Warns about images without a pose and poses without an image, one line each kind with the first name.
void warn_of_unmatched(const std::string& directory, const SparseModel& model, const ImageFolder& folder);

}  // namespace cpplus
