#include "cpplus/pipeline/poses_command.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "cpplus/core/parallel.h"
#include "cpplus/io/colmap_io.h"
#include "cpplus/io/image_io.h"
#include "cpplus/io/stamps_io.h"
#include "cpplus/io/test_files.h"
#include "cpplus/io/trajectory_io.h"

namespace cpplus {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using testing::HasSubstr;

/// Forward along the LiDAR's x axis, z up; 0.1 m ahead of it and 0.05 m above.
const char* const kRig =
    "cameras:\n"
    "  front:\n"
    "    {model: PINHOLE, width: 32, height: 24, params: [30, 30, 16, 12],\n"
    "     camera_from_lidar: {quaternion_wxyz: [0.5, 0.5, -0.5, 0.5], translation: [0, 0.05, -0.1]}}\n";

class PosesCommand : public FileTest {
 protected:
  PosesCommandOptions options() const {
    PosesCommandOptions options;
    options.trajectory = path("trajectory.txt");
    options.rig = path("rig.yaml");
    options.images = path("images");
    options.out = path("model");
    return options;
  }

  void write_images(const std::vector<std::string>& names) const {
    for (const std::string& name : names) write_png(path("images/" + name), ColorImage(32, 24));
  }

  void write_trajectory(const std::function<Rigid3(double)>& map_from_lidar, double begin, double end) const {
    Trajectory trajectory;
    for (int i = 0; begin + 0.1 * i <= end + 1e-9; ++i) {
      trajectory.push_back({begin + 0.1 * i, map_from_lidar(begin + 0.1 * i)});
    }
    write_tum(path("trajectory.txt"), trajectory);
  }

  /// Images by name from the model that was written.
  std::map<std::string, PosedImage> posed() const {
    std::map<std::string, PosedImage> images;
    for (const PosedImage& image : read_sparse_model(path("model")).images) images[image.name] = image;
    return images;
  }

  /// What a run warns of.
  static std::string warnings_of(const PosesCommandOptions& options, PosesSummary* summary) {
    testing::internal::CaptureStderr();
    *summary = poses_command(options);
    return testing::internal::GetCapturedStderr();
  }
};

Rigid3 along_x(double t) { return {Quaterniond::Identity(), Vector3d(1.5 * t, 0, 1)}; }

TEST_F(PosesCommand, PoseComputedByHand) {
  // The LiDAR stands at (1, 2, 3) and looks along the map's y axis.
  const Quaterniond left(std::sqrt(0.5), 0, 0, std::sqrt(0.5));
  write_trajectory([&](double) { return Rigid3(left, Vector3d(1, 2, 3)); }, 10, 11);
  write("rig.yaml", kRig);
  write_images({"10.5.png"});
  EXPECT_EQ(poses_command(options()).num_posed, 1u);
  const Rigid3 camera_from_map = posed().at("10.5.png").camera_from_map;
  EXPECT_TRUE(camera_center(camera_from_map).isApprox(Vector3d(1, 2.1, 3.05), 1e-9));
  EXPECT_TRUE((camera_from_map.rotation * Vector3d::UnitY()).isApprox(Vector3d::UnitZ(), 1e-9)) << "looks along y";
  EXPECT_TRUE((camera_from_map.rotation * Vector3d::UnitZ()).isApprox(-Vector3d::UnitY(), 1e-9)) << "stands upright";
  EXPECT_EQ(read_stamps(path("model/stamps.txt")).at("10.5.png"), 10.5);
  EXPECT_NE(read("model/cameras.txt").find("PINHOLE 32 24 30 30 16 12"), std::string::npos);
}

TEST_F(PosesCommand, OffsetAndHalfTheReadoutAreAddedToTheStamp) {
  write_trajectory(along_x, 0, 3);
  std::string rig = kRig;
  write("rig.yaml", rig.insert(rig.find("camera_from"), "time_offset_s: 0.1, readout_s: 0.04, "));
  write_images({"1.5.png"});
  poses_command(options());
  EXPECT_NEAR(camera_center(posed().at("1.5.png").camera_from_map).x(), 1.5 * (1.5 + 0.1 + 0.02) + 0.1, 1e-9);
  EXPECT_NEAR(read_stamps(path("model/stamps.txt")).at("1.5.png"), 1.62, 1e-12);
}

TEST_F(PosesCommand, WalkingPosesAreWithinTwoMillimetres) {
  const auto walk = [](double t) {
    const double phase = 2.0 * M_PI * 1.8 * t;
    const Quaterniond rotation = Eigen::AngleAxisd(1.2 * std::sin(0.65 * t), Vector3d::UnitZ()) *
                                 Eigen::AngleAxisd(0.015 * std::sin(phase + 0.6), Vector3d::UnitY());
    return Rigid3(rotation, Vector3d(1.5 * t, 2.0 * std::sin(0.65 * t), 1.4 + 0.025 * std::sin(phase)));
  };
  write_trajectory(walk, 0, 12);
  write("rig.yaml", kRig);
  std::vector<std::string> names;
  for (int i = 0; i < 30; ++i) names.push_back(fmt::format("{:.6f}.png", 0.5 + 0.3713 * i));
  write_images(names);
  EXPECT_EQ(poses_command(options()).num_posed, 30u);
  const Rigid3 camera_from_lidar(Quaterniond(0.5, 0.5, -0.5, 0.5), Vector3d(0, 0.05, -0.1));
  for (const auto& [name, image] : posed()) {
    const Rigid3 truth = camera_from_lidar * inverse(walk(std::stod(name)));
    EXPECT_LT((camera_center(image.camera_from_map) - camera_center(truth)).norm(), 0.002) << name;
    EXPECT_LT(rotation_angle_between(image.camera_from_map, truth), 0.02 * M_PI / 180.0) << name;
  }
}

TEST_F(PosesCommand, ImagesWithoutAPoseAreNamedAndCounted) {
  std::string trajectory;
  for (const double t : {10.0, 10.1, 10.2, 10.1, 10.3, 12.0, 12.1, 12.3, 12.2}) {
    trajectory += fmt::format("{} 0 0 0 0 0 0 1\n", t);
  }
  write("trajectory.txt", trajectory);
  write("rig.yaml", kRig);
  write_images({"a.png", "b.png", "c.png", "d.png", "e.png", "f.png", "g.png"});
  PosesCommandOptions with_stamps = options();
  with_stamps.stamps = write("s.txt", "a.png 9.5\nb.png 10.05\nc.png 11\nd.png 12.25\ne.png 12.4\nf.png 10.05\n");
  PosesSummary summary;
  const std::string warnings = warnings_of(with_stamps, &summary);
  EXPECT_EQ(summary.num_images, 7u);
  EXPECT_EQ(summary.num_posed, 2u);
  EXPECT_EQ(summary.num_outside, 2u);
  EXPECT_EQ(summary.num_in_gap, 1u);
  EXPECT_EQ(summary.num_without_stamp, 1u);
  EXPECT_EQ(summary.num_double_stamp, 1u);
  EXPECT_THAT(warnings,
              HasSubstr("1 image before the trajectory, which begins at 10 s, skipped, the first is 'a.png' at 9.5 s"));
  EXPECT_THAT(warnings,
              HasSubstr("1 image after the trajectory, which ends at 12.3 s, skipped, the first is 'e.png' at 12.4 s"));
  EXPECT_THAT(warnings,
              HasSubstr("1 image in gaps of the trajectory longer than 0.5 s skipped, the first is 'c.png' at 11 s"));
  EXPECT_THAT(warnings, HasSubstr("1 image without a stamp skipped, the first is 'g.png'"));
  EXPECT_THAT(
      warnings,
      HasSubstr("1 image with the stamp of another of the same camera skipped, the first is 'f.png' at 10.05 s"));
  EXPECT_THAT(warnings,
              HasSubstr("2 of 9 poses with a stamp before that of the pose above, sorted in; the first is at 10.1 s"));
  EXPECT_THAT(warnings,
              HasSubstr("1 of 9 poses with the stamp of another (or nearly), skipped; the first is at 10.1 s"));
  EXPECT_EQ(posed().size(), 2u);
}

TEST_F(PosesCommand, CamerasOfARigHaveFolders) {
  write_trajectory(along_x, 0, 3);
  write("rig.yaml",
        "trajectory_frame: body\n"
        "cameras:\n"
        "  left: {model: PINHOLE, width: 32, height: 24, params: [30, 30, 16, 12],\n"
        "         camera_from_body: {quaternion_wxyz: [0.5, 0.5, -0.5, 0.5], translation: [0.2, 0, 0]}}\n"
        "  right: {model: PINHOLE, width: 32, height: 24, params: [31, 31, 16, 12],\n"
        "          camera_from_body: {quaternion_wxyz: [0.5, 0.5, -0.5, 0.5], translation: [-0.2, 0, 0]}}\n");
  write_images({"left/1.0.png", "right/1.0.png", "rear/1.0.png"});
  PosesSummary summary;
  const std::string warnings = warnings_of(options(), &summary);
  EXPECT_EQ(summary.num_without_camera, 1u);
  EXPECT_THAT(warnings, HasSubstr("1 image of no camera of the rig skipped, the first is 'rear/1.0.png'"));
  const auto images = posed();
  EXPECT_NEAR(camera_center(images.at("left/1.0.png").camera_from_map).y(), 0.2, 1e-9);
  EXPECT_NEAR(camera_center(images.at("right/1.0.png").camera_from_map).y(), -0.2, 1e-9);
  EXPECT_NE(images.at("left/1.0.png").camera_id, images.at("right/1.0.png").camera_id);
  PosesCommandOptions of_lidar = options();
  of_lidar.trajectory_frame = "lidar";
  EXPECT_ERROR(poses_command(of_lidar), "rig.yaml: does not say where camera 'left' is on the LiDAR");
}

TEST_F(PosesCommand, AnInvertedExtrinsicIsWarnedOf) {
  write_trajectory(along_x, 0, 3);
  write("rig.yaml", kRig);
  write_images({"1.0.png", "2.0.png"});
  PosesSummary summary;
  EXPECT_EQ(warnings_of(options(), &summary), "");
  std::string rig = kRig;
  rig.replace(rig.find("[0.5, 0.5, -0.5, 0.5]"), 21, "[0.5, -0.5, 0.5, -0.5]");
  write("rig.yaml", rig);
  EXPECT_THAT(
      warnings_of(options(), &summary),
      HasSubstr("rig.yaml: the images of camera 'front' stand 90 deg from upright, but 0 deg if its extrinsic is "
                "inverted"));
  EXPECT_EQ(summary.num_posed, 2u) << "it is only a warning";
  PosesCommandOptions unchecked = options();
  unchecked.up = "none";
  EXPECT_EQ(warnings_of(unchecked, &summary), "");
}

TEST_F(PosesCommand, ResizedImagesScaleTheCamera) {
  write_trajectory(along_x, 0, 3);
  std::string rig = kRig;
  rig.replace(rig.find("width: 32, height: 24, params: [30, 30, 16, 12]"), 47,
              "width: 64, height: 48, params: [60, 60, 33, 24]");
  write("rig.yaml", rig);
  write_images({"1.0.png"});
  EXPECT_ERROR(poses_command(options()),
               "1.0.png: is 32x24, its camera 'front' 64x48; image_scale 0.5 scales the camera");
  PosesCommandOptions half = options();
  half.image_scale = 0.5;
  poses_command(half);
  EXPECT_NE(read("model/cameras.txt").find("PINHOLE 32 24 30 30 16.5 12"), std::string::npos)
      << read("model/cameras.txt");
}

TEST_F(PosesCommand, OneThreadAndSeveralWriteTheSame) {
  write_trajectory(along_x, 0, 3);
  write("rig.yaml", kRig);
  write_images({"1.0.png", "2.0.png", "not_an_image.png"});
  write("images/1.0.png", "this is no PNG");  // its pose does not depend on its pixels
  set_num_threads(1);
  EXPECT_EQ(poses_command(options()).num_posed, 2u);
  const std::string one = read("model/images.txt") + read("model/stamps.txt");
  set_num_threads(4);
  poses_command(options());
  set_num_threads(0);
  EXPECT_EQ(read("model/images.txt") + read("model/stamps.txt"), one);
}

TEST_F(PosesCommand, BadInput) {
  write_trajectory(along_x, 0, 3);
  write("rig.yaml", kRig);
  EXPECT_ERROR(poses_command(options()), "images: not a folder of images");
  std::filesystem::create_directory(path("images"));
  EXPECT_ERROR(poses_command(options()), "images: holds no images");
  write_images({"000001.png"});
  EXPECT_ERROR(poses_command(options()), "images: names like '000001.png' seem to count images, not time");
  PosesCommandOptions seconds = options();
  seconds.stamp_unit = "s";
  EXPECT_EQ(poses_command(seconds).num_posed, 1u);
  seconds.stamps = write("s.txt", "000001.png 77\n");
  EXPECT_ERROR(poses_command(seconds), "images: none of its 1 image gets a pose from");
  EXPECT_THROW(poses_command(PosesCommandOptions{}), UsageError);
  for (const auto& spoil : std::vector<std::function<void(PosesCommandOptions*)>>{
           [](auto* o) { o->stamp_unit = "days"; }, [](auto* o) { o->trajectory_frame = "car"; },
           [](auto* o) { o->max_gap_s = 0; }, [](auto* o) { o->image_scale = -1; }, [](auto* o) { o->up = "w"; }}) {
    PosesCommandOptions bad = options();
    spoil(&bad);
    EXPECT_THROW(bad.validate(), UsageError);
  }
}

}  // namespace
}  // namespace cpplus
