#pragma once

#include <string>
#include <vector>

#include "cpplus/io/imported_project.h"

namespace cpplus {

// Helpers of the importers.

/// "FOLDER/NAME", which must be a file. Throws Error naming it.
std::string required_file(const std::string& folder, const std::string& name);

/// The first of the names that is a file in the folder, with its path; "" when none is.
std::string first_file(const std::string& folder, const std::vector<std::string>& names);

/// Names of the files in the folder (not below it) that end so, sorted; none where there is no such folder.
std::vector<std::string> files_with_extension(const std::string& folder, const std::string& extension);

/// Images below the folder under their relative names.
std::vector<SourceFile> image_files(const std::string& folder);

/// A model of one camera whose images have the poses, in the order given.
SparseModel model_of_images(const Camera& camera, const std::vector<std::string>& names,
                            const std::vector<Rigid3>& camera_from_map);

}  // namespace cpplus
