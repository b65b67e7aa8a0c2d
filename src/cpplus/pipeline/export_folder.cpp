#include "cpplus/pipeline/export_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <system_error>

#include "cpplus/core/error.h"

namespace cpplus {
namespace fs = std::filesystem;

ExportFolder::ExportFolder(const std::string& path) : target_(fs::absolute(path).lexically_normal()) {
  if (!target_.has_filename()) target_ = target_.parent_path();
  std::error_code failure;
  if (fs::exists(target_) && (!fs::is_directory(target_) || !fs::is_empty(target_, failure))) {
    throw Error(fmt::format("{}: is there already; an export makes a new folder", path));
  }
  temporary_ = target_.parent_path() / fmt::format(".{}.{}.partial", target_.filename().string(), getpid());
  fs::remove_all(temporary_, failure);
  fs::create_directories(temporary_, failure);
  if (failure) throw Error(fmt::format("{}: cannot make the folder: {}", path, failure.message()));
}

ExportFolder::~ExportFolder() {
  std::error_code ignored;
  if (!committed_) fs::remove_all(temporary_, ignored);
}

void ExportFolder::commit() {
  std::error_code failure;
  fs::remove(target_, failure);  // an empty folder may stand there
  fs::rename(temporary_, target_, failure);
  if (failure) throw Error(fmt::format("{}: cannot write: {}", target_.string(), failure.message()));
  committed_ = true;
}

}  // namespace cpplus
