#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "cpplus/core/random.h"
#include "cpplus/io/point_cloud_io.h"
#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

class SlowCloudMemoryTest : public FileTest {
 protected:
  void write_files() const;
};

/// A figure of this process in bytes: "VmRSS" (memory now) or "VmHWM" (its peak).
size_t memory_bytes(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(name + ":")) return 1024 * std::strtoull(line.c_str() + name.size() + 1, nullptr, 10);
  }
  return 0;
}

size_t cloud_bytes(const PointCloud& cloud) {
  return cloud.positions.size() * sizeof(Eigen::Vector3f) + cloud.intensities.size() * sizeof(float) +
         cloud.colors.size() * sizeof(Rgb) + cloud.stamps_s.size() * sizeof(double) +
         cloud.num_views.size() * sizeof(uint16_t) + cloud.best_images.size() * sizeof(uint32_t) +
         cloud.color_spreads.size();
}

/// Runs the function in a process of its own and returns its result, 0..255. Memory that this process has used and
/// freed would otherwise hide what a reader takes.
template <typename Function>
int run_apart(const Function& function) {
  const pid_t child = fork();
  if (child == 0) _exit(function());
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// Peak of memory while reading, as a multiple of the cloud's own size, in percent.
int peak_percent(const std::string& path) {
  return run_apart([&]() {
    const size_t before = memory_bytes("VmRSS");
    const PointCloud cloud = read_point_cloud(path);
    const size_t peak = memory_bytes("VmHWM") - before;
    return static_cast<int>(std::min<size_t>(255, 100 * peak / cloud_bytes(cloud)));
  });
}

PointCloud random_cloud(size_t size) {
  Random random(7);
  PointCloud cloud;
  for (size_t i = 0; i < size; ++i) {
    cloud.positions.emplace_back(random.uniform(-50, 50), random.uniform(-50, 50), random.uniform(0, 5));
    cloud.intensities.push_back(static_cast<float>(random.below(256)));
    cloud.colors.push_back({static_cast<uint8_t>(random.next()), 0, 255});
    cloud.stamps_s.push_back(1e-3 * static_cast<double>(i));
  }
  return cloud;
}

void SlowCloudMemoryTest::write_files() const {
  const PointCloud cloud = random_cloud(1000000);
  for (const char* name : {"a.pcd", "a.ply", "a.las"}) write_point_cloud(path(name), cloud);
  std::ofstream text(path("text.pcd"));
  text << "FIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH " << cloud.size()
       << "\nHEIGHT 1\nPOINTS " << cloud.size() << "\nDATA ascii\n";
  for (size_t i = 0; i < cloud.size(); ++i) {
    text << cloud.positions[i].transpose() << " " << cloud.intensities[i] << "\n";
  }
  // Compressed with literal runs only, which any encoder may do; the columns are all zero but for their literals.
  std::ofstream packed(path("packed.pcd"), std::ios::binary);
  const size_t decoded_size = cloud.size() * sizeof(Eigen::Vector3f);
  packed << "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " << cloud.size() << "\nHEIGHT 1\nPOINTS "
         << cloud.size() << "\nDATA binary_compressed\n"
         << bytes_of(static_cast<uint32_t>(decoded_size / 32 * 33)) << bytes_of(static_cast<uint32_t>(decoded_size));
  for (size_t i = 0; i < decoded_size / 32; ++i) packed << '\x1F' << std::string(32, '\x3F');
}

TEST_F(SlowCloudMemoryTest, ReadersNeedLittleMoreThanTheCloud) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer's own memory would be measured";
#endif
  const int written = run_apart([&]() {
    write_files();
    return 0;
  });
  ASSERT_EQ(written, 0);
  for (const char* name : {"a.pcd", "a.ply", "a.las", "text.pcd", "packed.pcd"}) {
    const int percent = peak_percent(path(name));
    EXPECT_GE(percent, 90) << name << ": the measurement itself is wrong";
    EXPECT_LE(percent, 130) << name;
    RecordProperty(name, percent);
  }
}

}  // namespace
}  // namespace cpplus
