#pragma once

#include <string>
#include <vector>

namespace cpplus {

/// The smallest good input of every command, below one folder: a wall of 1200 points 3 m in front of two 64x48 images
/// (a.png, b.png), a COLMAP text model, stamps, a trajectory, a rig, and the wall as two scans with poses. Tests spoil
/// one thing of it at a time.
class TinyScene {
 public:
  explicit TinyScene(std::string directory);

  std::string path(const std::string& name) const { return directory_ + "/" + name; }
  const std::string& directory() const { return directory_; }

  void write(const std::string& name, const std::string& text) const;
  std::string read(const std::string& name) const;
  /// Replaces the only occurrence of `from` in a file.
  void replace(const std::string& name, const std::string& from, const std::string& to) const;
  /// Cuts a file to its first `size` bytes.
  void truncate(const std::string& name, size_t size) const;
  /// The map in another format, by extension.
  void convert_map(const std::string& name) const;

  /// Arguments that work; `more` follows them.
  std::vector<std::string> colorize(const std::vector<std::string>& more = {}) const;
  std::vector<std::string> refine(const std::vector<std::string>& more = {}) const;
  std::vector<std::string> clean(const std::vector<std::string>& more = {}) const;
  std::vector<std::string> poses(const std::vector<std::string>& more = {}) const;
  /// `export` to DIR/out with everything that a format may need but stamps.
  std::vector<std::string> exports(const std::string& format, const std::vector<std::string>& more = {}) const;
  /// `colorize` with another value for one flag.
  std::vector<std::string> colorize_with(const std::string& flag, const std::string& value) const;

 private:
  std::string directory_;
};

/// The arguments with the value after `flag` replaced, or flag and value added.
std::vector<std::string> with_flag(std::vector<std::string> arguments, const std::string& flag,
                                   const std::string& value);

}  // namespace cpplus
