#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "cpplus/core/error.h"

namespace cpplus {

/// Test fixture: a folder of its own for each test, removed afterwards.
class FileTest : public ::testing::Test {
 protected:
  FileTest() {
    const ::testing::TestInfo* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("cpplus_" + std::string(info->test_suite_name()) + "_" + info->name() + "_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  ~FileTest() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  std::string write(const std::string& name, const std::string& bytes) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(path(name), std::ios::binary) << bytes;
    return path(name);
  }

  std::string read(const std::string& name) const {
    std::ostringstream bytes;
    bytes << std::ifstream(path(name), std::ios::binary).rdbuf();
    return bytes.str();
  }

  size_t num_files() const {
    return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
  }

 private:
  std::filesystem::path folder_;
};

/// Expects the statement to throw Error with one line that contains the text.
#define EXPECT_ERROR(statement, text)                                      \
  try {                                                                    \
    static_cast<void>(statement);                                          \
    ADD_FAILURE() << "no Error; expected one with: " << (text);            \
  } catch (const ::cpplus::Error& error) {                                 \
    EXPECT_THAT(error.what(), ::testing::HasSubstr(text));                 \
    EXPECT_THAT(error.what(), ::testing::Not(::testing::HasSubstr("\n"))); \
  }

/// The bytes of a number, little-endian.
template <typename T>
std::string bytes_of(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof(T)};
}

}  // namespace cpplus
