#include "cpplus/pipeline/atomic_folder.h"

#include <fmt/format.h>

#include <system_error>

#include "cpplus/core/error.h"
#include "cpplus/io/atomic_file.h"

namespace cpplus {

namespace fs = std::filesystem;

namespace {

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  return names;
}

}  // namespace

AtomicFolder::AtomicFolder(const std::string& path) : target_(fs::absolute(path).lexically_normal()) {
  if (!target_.has_filename()) target_ = target_.parent_path();
  temporary_ = temporary_path(target_.string());
  std::error_code failure;
  fs::remove_all(temporary_, failure);
  fs::create_directories(temporary_, failure);
  if (failure) throw Error(fmt::format("{}: cannot make the folder: {}", path, failure.message()));
}

AtomicFolder::~AtomicFolder() {
  std::error_code ignored;
  if (!committed_) fs::remove_all(temporary_, ignored);
}

void AtomicFolder::commit() {
  std::error_code failure;
  fs::remove(target_, failure);
  fs::rename(temporary_, target_, failure);
  if (failure) throw Error(fmt::format("{}: cannot write: {}", target_.string(), failure.message()));
  committed_ = true;
}

void AtomicFolder::commit_into(const std::function<bool(const std::string&)>& is_ours, const std::string& last) {
  try {
    for (const std::string& name : names_in(target_)) {
      if (name != last && is_ours(name)) fs::remove_all(target_ / name);
    }
    for (const std::string& name : names_in(temporary_)) {
      if (name != last) fs::rename(temporary_ / name, target_ / name);
    }
    fs::rename(temporary_ / last, target_ / last);
  } catch (const fs::filesystem_error& failure) {
    throw Error(fmt::format("{}: cannot write: {}", target_.string(), failure.code().message()));
  }
}

}  // namespace cpplus
