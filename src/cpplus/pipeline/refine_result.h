#pragma once

#include <string>
#include <vector>

#include "cpplus/geometry/sparse_model.h"
#include "cpplus/pipeline/feature_store.h"
#include "cpplus/pipeline/refine_command.h"
#include "cpplus/pipeline/refine_images.h"

namespace cpplus {

/// The folder that `refine` wrote, and what it was made of.
struct RefineResult {
  std::string folder;
  std::string report_json;
  std::vector<std::string> image_names;  // in the order of report.json
  RefineInputs inputs;
  RefineImagesOptions stages;
  bool keep_features = true;  // see RefineCommandOptions
  int max_group_points = RefineCommandOptions().max_group_points;
  FeatureStoreOptions tiles;
  SparseModel coarse;
  SparseModel refined;
};

/// `folder` itself where it holds report.json, else its only sub-folder that does, as `run` leaves it. Throws Error
/// where there is none or more than one.
std::string find_refine_folder(const std::string& folder);

/// Reads the folder. Inputs that `given` names count instead of those of report.json. Throws Error naming what is
/// missing or broken.
RefineResult read_refine_result(const std::string& folder, const RefineInputs& given);

/// Where each image of report.json stands in a model, by name; model.images.size() where it does not.
std::vector<size_t> places_in_model(const std::vector<std::string>& names, const SparseModel& model);

}  // namespace cpplus
