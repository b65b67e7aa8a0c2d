#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace cpplus {

/// A folder that appears whole or not at all: it is filled beside its place, below temporary(), and renamed to its
/// place by commit(), which takes away an empty folder there. Without commit() it is removed.
class AtomicFolder {
 public:
  /// Throws Error naming the path where the folder cannot be made.
  explicit AtomicFolder(const std::string& path);
  ~AtomicFolder();
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;

  const std::filesystem::path& temporary() const { return temporary_; }
  const std::filesystem::path& target() const { return target_; }

  void commit();

  /// Instead of commit(), where a folder stands that holds other things as well: of its entries those go for which
  /// `is_ours(name)` holds, and the new ones come, the one called `last` in the end. Whoever finds that one as it
  /// was before must expect a mixture of old and new.
  void commit_into(const std::function<bool(const std::string&)>& is_ours, const std::string& last);

 private:
  std::filesystem::path target_;
  std::filesystem::path temporary_;
  bool committed_ = false;
};

}  // namespace cpplus
