#include "cpplus/pipeline/refine_result.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "cpplus/core/error.h"
#include "cpplus/io/colmap_io.h"

namespace cpplus {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::string read_text(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Error(fmt::format("{}: cannot open; it is what `cpplus refine` writes", path));
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string input(const Json& report, const std::string& key, const std::string& given, const std::string& path) {
  if (!given.empty()) return given;
  if (!report.contains("inputs")) {
    throw Error(fmt::format("{}: names no inputs (written by an older version); give --{}", path, key));
  }
  return report.at("inputs").at(key).get<std::string>();
}

// Options that the file has and this version does not are left out.
void set_options(const Json& values, const std::vector<OptionField>& fields) {
  for (const OptionField& field : fields) {
    if (!values.contains(field.path)) continue;
    const Json& value = values.at(field.path);
    set_option(field, field.path, value.is_string() ? value.get<std::string>() : value.dump());
  }
}

}  // namespace

std::string find_refine_folder(const std::string& folder) {
  if (!fs::is_directory(folder)) throw Error(fmt::format("{}: not a folder", folder));
  if (fs::exists(fs::path(folder) / "report.json")) return folder;
  std::vector<std::string> found;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory() && fs::exists(entry.path() / "report.json")) found.push_back(entry.path().string());
  }
  if (found.empty()) {
    throw Error(fmt::format("{}: holds no report.json; give the folder that `cpplus refine` wrote", folder));
  }
  std::sort(found.begin(), found.end());
  if (found.size() > 1) {
    throw Error(fmt::format("{}: holds {} results ({} and others); give one of them", folder, found.size(), found[0]));
  }
  return found.front();
}

RefineResult read_refine_result(const std::string& folder, const RefineInputs& given) {
  RefineResult result;
  result.folder = find_refine_folder(folder);
  const std::string path = result.folder + "/report.json";
  result.report_json = read_text(path);
  try {
    const Json report = Json::parse(result.report_json);
    result.inputs.map = input(report, "map", given.map, path);
    result.inputs.images = input(report, "images", given.images, path);
    result.inputs.poses = input(report, "poses", given.poses, path);
    const Json& options = report.at("options");
    set_options(options, list_options(result.stages));
    set_options(options, list_options(result.tiles, "tiles"));
    result.keep_features = options.value("keep_features", result.keep_features);
    result.max_group_points = options.value("max_group_points", result.max_group_points);
    for (const Json& image : report.at("images")) result.image_names.push_back(image.at("name"));
  } catch (const Json::exception& error) {
    throw Error(fmt::format("{}: not a report of `cpplus refine`: {}", path, error.what()));
  }
  result.coarse = read_sparse_model(result.inputs.poses);
  result.refined = read_sparse_model(result.folder + "/sparse");
  return result;
}

std::vector<size_t> places_in_model(const std::vector<std::string>& names, const SparseModel& model) {
  std::map<std::string, size_t> places;
  for (size_t i = 0; i < model.images.size(); ++i) places[model.images[i].name] = i;
  std::vector<size_t> result;
  for (const std::string& name : names) {
    const auto found = places.find(name);
    result.push_back(found == places.end() ? model.images.size() : found->second);
  }
  return result;
}

}  // namespace cpplus
