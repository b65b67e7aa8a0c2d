#include "cpplus/io/trajectory_io.h"

#include "cpplus/io/stamps_io.h"
#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using TumTest = FileTest;
using StampsTest = FileTest;

TEST_F(TumTest, ReadsStampTranslationAndQuaternionWithWLast) {
  const Trajectory trajectory =
      read_tum(write("t.txt", "# stamp ...\n1.5 1 2 3 0 0 0.6 0.8\n\n  2.5\t4 5 6 0 0 0 1 # the end\r\n"));
  ASSERT_EQ(trajectory.size(), 2u);
  EXPECT_EQ(trajectory[0].stamp_s, 1.5);
  EXPECT_EQ(trajectory[0].map_from_sensor.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_NEAR(trajectory[0].map_from_sensor.rotation.z(), 0.6, 1e-15);
  EXPECT_NEAR(trajectory[0].map_from_sensor.rotation.w(), 0.8, 1e-15);
  EXPECT_EQ(trajectory[1].map_from_sensor.translation, Eigen::Vector3d(4, 5, 6));
}

TEST_F(TumTest, WrittenTrajectoryComesBackExactly) {
  Trajectory trajectory;
  for (int i = 0; i < 50; ++i) {
    trajectory.push_back(
        {1.7e9 + i / 3.0, Rigid3(Eigen::Quaterniond(0.1 * i, 1, 0.3, -0.7), Eigen::Vector3d(i / 7.0, 1e-9, 1e6 / 3))});
  }
  write_tum(path("t.txt"), trajectory);
  const Trajectory back = read_tum(path("t.txt"));
  ASSERT_EQ(back.size(), trajectory.size());
  for (size_t i = 0; i < back.size(); ++i) {
    EXPECT_EQ(back[i].stamp_s, trajectory[i].stamp_s);
    EXPECT_EQ(back[i].map_from_sensor.translation, trajectory[i].map_from_sensor.translation);
    EXPECT_EQ(back[i].map_from_sensor.rotation.coeffs(), trajectory[i].map_from_sensor.rotation.coeffs());
  }
}

TEST_F(TumTest, KittiHoldsTheRowsOfTheMatrix) {
  // A quarter turn about z: x becomes y.
  const Rigid3 map_from_sensor(Eigen::Quaterniond(Eigen::AngleAxisd(M_PI_2, Eigen::Vector3d::UnitZ())),
                               Eigen::Vector3d(4, 5, 6));
  write_kitti(path("poses.txt"), {{1.5, map_from_sensor}, {2.25, Rigid3()}});
  write_times(path("times.txt"), {{1.5, map_from_sensor}, {2.25, Rigid3()}});
  std::istringstream words(read("poses.txt"));
  const double expected[] = {0, -1, 0, 4, 1, 0, 0, 5, 0, 0, 1, 6, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  for (const double value : expected) {
    double word = NAN;
    words >> word;
    EXPECT_NEAR(word, value, 1e-15);
  }
  EXPECT_EQ(read("times.txt"), "1.5\n2.25\n");
}

TEST_F(TumTest, BadLinesAreErrorsThatNameThem) {
  const auto expect = [&](const std::string& bytes, const std::string& text) {
    EXPECT_ERROR(read_tum(write("t.txt", bytes)), text);
  };
  const std::string good = "1 0 0 0 0 0 0 1\n";
  expect("", "t.txt: holds no poses");
  expect(good + "2,0,0,0,0,0,0,1\n", "t.txt:2: TUM lines are separated by blanks, this one has commas");
  expect(good + "2 0 0 0 0 0 0\n", "t.txt:2: 7 values");
  expect(good + "2 0 0 0 0 0 0 1 5\n", "t.txt:2: 9 values");
  expect(good + "2 0 0 nan 0 0 0 1\n", "t.txt:2: not a finite number: 'nan'");
  expect(good + "2 0 0 0 0 0 0 0\n", "t.txt:2: the quaternion has length 0");
  expect(good + "0.5 0 0 0 0 0 0 1\n", "t.txt:2: stamp 0.5 does not come after 1");
  expect(good + good, "t.txt:2: stamp 1 does not come after 1");
}

TEST_F(StampsTest, NamesMayContainBlanks) {
  const auto stamps =
      read_stamps(write("s.txt", "# name seconds\n000000.jpg 1.750296\nmy photo 2.jpg   1700000000.25\r\n"));
  ASSERT_EQ(stamps.size(), 2u);
  EXPECT_EQ(stamps.at("000000.jpg"), 1.750296);
  EXPECT_EQ(stamps.at("my photo 2.jpg"), 1700000000.25);
}

TEST_F(StampsTest, BadLinesAreErrorsThatNameThem) {
  const auto expect = [&](const std::string& bytes, const std::string& text) {
    EXPECT_ERROR(read_stamps(write("s.txt", bytes)), text);
  };
  expect("# nothing\n", "s.txt: holds no stamps");
  expect("a.jpg 1\n2.5\n", "s.txt:2: not `name seconds`: '2.5'");
  expect("a.jpg 1\nb.jpg\n", "s.txt:2: not `name seconds`: 'b.jpg'");
  expect("a.jpg one\n", "s.txt:1: not `name seconds`");
  expect("a.jpg inf\n", "s.txt:1: not `name seconds`");
  expect("a.jpg 1\na.jpg 2\n", "s.txt:2: 'a.jpg' occurs twice");
}

}  // namespace
}  // namespace cpplus
