#pragma once

#include <filesystem>
#include <string>

namespace cpplus {

/// A new folder that appears whole or not at all: files go into temporary(), and commit() renames it to its place.
/// Without commit() it is removed.
class ExportFolder {
 public:
  /// Throws Error where the path is a file or a folder that is not empty, and where the
  /// temporary beside it cannot be made.
  explicit ExportFolder(const std::string& path);
  ~ExportFolder();
  ExportFolder(const ExportFolder&) = delete;
  ExportFolder& operator=(const ExportFolder&) = delete;

  const std::filesystem::path& temporary() const { return temporary_; }
  /// The absolute path that the folder will have.
  const std::filesystem::path& target() const { return target_; }

  void commit();

 private:
  std::filesystem::path target_;
  std::filesystem::path temporary_;
  bool committed_ = false;
};

}  // namespace cpplus
