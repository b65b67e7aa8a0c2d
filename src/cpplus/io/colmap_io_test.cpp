#include "cpplus/io/colmap_io.h"

#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

const std::string kCameras =
    "# a comment\n1 OPENCV 1024 768 667.25 668 515.5 379.5 -0.1 0.03 0.0007 -0.0005\n"
    "2 SIMPLE_PINHOLE 640 480 500 320 240\n";
const std::string kImages =
    "# comment\n"
    "7 1 0 0 0 0.1 0.2 0.3 1 left/my photo 1.jpg\n"
    "10.5 20.5 4 11.5 21.5 -1\n"
    "3 0.5 0.5 -0.5 0.5 1 2 3 2 b.png\n"
    "\n"
    "5 1 0 0 0 0 0 0 2 c.png";
const std::string kPoints = "4 1 2 3 255 0 9 0.25 7 0\n";

class ColmapTest : public FileTest {
 protected:
  std::string write_model(const std::string& cameras, const std::string& images, const std::string& points) {
    write("model/cameras.txt", cameras);
    write("model/images.txt", images);
    write("model/points3D.txt", points);
    return path("model");
  }
};

void expect_same(const SparseModel& x, const SparseModel& y) {
  ASSERT_EQ(x.cameras.size(), y.cameras.size());
  for (const auto& [id, camera] : x.cameras) {
    ASSERT_EQ(y.cameras.count(id), 1u);
    EXPECT_EQ(camera.model(), y.cameras.at(id).model());
    EXPECT_EQ(camera.width(), y.cameras.at(id).width());
    EXPECT_EQ(camera.height(), y.cameras.at(id).height());
    ASSERT_EQ(camera.params().size(), y.cameras.at(id).params().size());
    for (size_t i = 0; i < camera.params().size(); ++i) {
      EXPECT_DOUBLE_EQ(camera.params()[i], y.cameras.at(id).params()[i]);
    }
  }
  ASSERT_EQ(x.images.size(), y.images.size());
  for (size_t i = 0; i < x.images.size(); ++i) {
    EXPECT_EQ(x.images[i].id, y.images[i].id);
    EXPECT_EQ(x.images[i].name, y.images[i].name);
    EXPECT_EQ(x.images[i].camera_id, y.images[i].camera_id);
    EXPECT_EQ(x.images[i].camera_from_map.rotation.coeffs(), y.images[i].camera_from_map.rotation.coeffs());
    EXPECT_EQ(x.images[i].camera_from_map.translation, y.images[i].camera_from_map.translation);
  }
  ASSERT_EQ(x.points.size(), y.points.size());
  for (size_t i = 0; i < x.points.size(); ++i) {
    EXPECT_EQ(x.points[i].id, y.points[i].id);
    EXPECT_EQ(x.points[i].position, y.points[i].position);
    EXPECT_EQ(x.points[i].color, y.points[i].color);
    EXPECT_EQ(x.points[i].error_px, y.points[i].error_px);
    ASSERT_EQ(x.points[i].track.size(), y.points[i].track.size());
    for (size_t k = 0; k < x.points[i].track.size(); ++k) {
      EXPECT_EQ(x.points[i].track[k].image_id, y.points[i].track[k].image_id);
      EXPECT_TRUE(x.points[i].track[k].pixel.isApprox(y.points[i].track[k].pixel, 1e-15));
    }
  }
}

/// Numbers that need all their digits.
SparseModel awkward_model() {
  SparseModel model;
  model.cameras[3] = Camera(CameraModel::kOpenCv, 1024, 768, {667.1, 667.3, 514.7, 378.9, -0.1 / 3, 0.03, 7e-4, -5e-4});
  model.cameras[9] = Camera(CameraModel::kEquirectangular, 2048, 1024,
                            std::vector<double>(camera_model_num_params(CameraModel::kEquirectangular), 1024));
  for (uint32_t i = 0; i < 20; ++i) {
    PosedImage image;
    image.id = 40 - i;
    image.name = "image " + std::to_string(i) + ".jpg";
    image.camera_id = i % 2 == 0 ? 3 : 9;
    image.camera_from_map =
        Rigid3(Eigen::Quaterniond(1.0 / (i + 3), 0.1 * i, -0.3, 0.7), Eigen::Vector3d(i / 3.0, 1e-7, -1e5 / 7));
    model.images.push_back(image);
  }
  for (uint32_t i = 0; i < 5; ++i) {
    SparsePoint point;
    point.id = 100 + i;
    point.position = {1.0 / 3, i * 0.1, -7};
    point.color = {1, 2, static_cast<uint8_t>(i)};
    point.error_px = 0.1 * i;
    point.track = {{40, {i * 1.1, 3.3}}, {37, {0.7, i * 2.2}}};
    model.points.push_back(point);
  }
  return model;
}

TEST_F(ColmapTest, TextIsReadWithOurPixelConvention) {
  const SparseModel model = read_sparse_model(write_model(kCameras, kImages, kPoints));
  ASSERT_EQ(model.cameras.size(), 2u);
  EXPECT_THAT(model.cameras.at(1).params(), testing::ElementsAre(667.25, 668, 515, 379, -0.1, 0.03, 0.0007, -0.0005));
  EXPECT_THAT(model.cameras.at(2).params(), testing::ElementsAre(500, 319.5, 239.5));
  ASSERT_EQ(model.images.size(), 3u);
  EXPECT_EQ(model.images[0].id, 7u);
  EXPECT_EQ(model.images[0].name, "left/my photo 1.jpg");
  EXPECT_EQ(model.images[0].camera_from_map.translation, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(model.images[1].name, "b.png");
  EXPECT_EQ(model.images[1].camera_from_map.rotation.y(), -0.5);
  EXPECT_EQ(model.images[2].name, "c.png");
  ASSERT_EQ(model.points.size(), 1u);
  EXPECT_EQ(model.points[0].color, (Rgb{255, 0, 9}));
  ASSERT_EQ(model.points[0].track.size(), 1u);
  EXPECT_EQ(model.points[0].track[0].image_id, 7u);
  EXPECT_EQ(model.points[0].track[0].pixel, Eigen::Vector2d(10, 20));
}

TEST_F(ColmapTest, TextAndBinaryComeBackExactly) {
  const SparseModel model = awkward_model();
  write_sparse_model_text(path("text"), model);
  expect_same(read_sparse_model(path("text")), model);
  write_sparse_model_binary(path("binary"), model);
  expect_same(read_sparse_model(path("binary")), model);
  // A text file survives reading and writing to the last digit.
  write_sparse_model_text(path("again"), read_sparse_model(path("text")));
  EXPECT_EQ(read("again/images.txt"), read("text/images.txt"));
  EXPECT_EQ(read("again/points3D.txt"), read("text/points3D.txt"));
}

TEST_F(ColmapTest, WrittenPrincipalPointIsColmaps) {
  SparseModel model;
  model.cameras[1] = Camera(CameraModel::kPinhole, 640, 480, {500, 500, 319.5, 239.5});
  write_sparse_model_text(path("m"), model);
  EXPECT_THAT(read("m/cameras.txt"), testing::HasSubstr("\n1 PINHOLE 640 480 500 500 320 240\n"));
}

TEST_F(ColmapTest, EquirectangularHasNoPrincipalPointToShift) {
  const SparseModel model = awkward_model();
  write_sparse_model_text(path("m"), model);
  std::string expected = "\n9 EQUIRECTANGULAR 2048 1024";
  for (size_t i = 0; i < camera_model_num_params(CameraModel::kEquirectangular); ++i) expected += " 1024";
  EXPECT_THAT(read("m/cameras.txt"), testing::HasSubstr(expected + "\n"));
}

TEST_F(ColmapTest, BadTextModelsAreErrors) {
  const auto expect = [&](const std::string& cameras, const std::string& images, const std::string& points,
                          const std::string& text) {
    const std::string folder = write_model(cameras, images, points);
    EXPECT_ERROR(read_sparse_model(folder), text);
  };
  const std::string camera = "1 PINHOLE 640 480 500 500 320 240\n";
  const std::string pose = "1 0 0 0 0 0 0 ";
  expect("1 FOV 640 480 500 500 320 240 1\n", "", "", "cameras.txt:1: camera 1: unknown camera model 'FOV'");
  expect("1 PINHOLE 640 480 0 500 320 240\n", "", "", "cameras.txt:1: camera 1:");
  expect("1 PINHOLE 640 480 -500 500 320 240\n", "", "", "cameras.txt:1: camera 1:");
  expect("1 PINHOLE 640 480 500 500 320\n", "", "", "cameras.txt:1: camera 1:");
  expect("1 PINHOLE 640 480 500 500 nan 240\n", "", "", "cameras.txt:1: camera 1:");
  expect("1 PINHOLE 640 480 500 500 320 240x\n", "", "", "PARAMS is not a valid number: '240x'");
  expect("1 PINHOLE -640 480 500 500 320 240\n", "", "", "WIDTH is not a valid number: '-640'");
  expect("1 PINHOLE 99999999999 480 500 500 320 240\n", "", "", "size 99999999999 x 480");
  expect(camera + camera, "", "", "cameras.txt:2: camera 1: occurs twice");
  expect(camera, "1 " + pose + "2 a.jpg\n\n", "", "images.txt:1: image 1 'a.jpg': its camera 2 is missing");
  expect(camera, "1 0 0 0 0 0 0 0 1 a.jpg\n\n", "", "quaternion 0 0 0 0 has length 0, not 1");
  expect(camera, "1 2 0 0 0 0 0 0 1 a.jpg\n\n", "", "has length 2, not 1");
  expect(camera, "1 1 0 0 0 nan 0 0 1 a.jpg\n\n", "", "'a.jpg': its pose is not finite");
  expect(camera, "1 " + pose + "1\n\n", "", "has no name");
  expect(camera, "1 1 0 0 0 0 0\n\n", "", "images.txt:1: TZ is missing");
  expect(camera, "1 " + pose + "1 a.jpg\n\n2 " + pose + "1 a.jpg\n\n", "",
         "images.txt:3: image 2 'a.jpg': the name occurs twice");
  expect(camera, "1 " + pose + "1 a.jpg\n\n1 " + pose + "1 b.jpg\n\n", "", "the id occurs twice");
  // The second lines left out: the next image would be taken for observations.
  expect(camera, "1 " + pose + "1 a.jpg\n2 " + pose + "1 b.jpg\n", "",
         "images.txt:2: X of POINTS2D (the second line of an image) is not");
  expect(camera, "1 " + pose + "1 a.jpg\n\n", "1 0 0 0 1 2 3 0.5 8 0\n", "point 1: its track names image 8");
  expect(camera, "1 " + pose + "1 a.jpg\n1 1 1\n", "1 0 0 0 1 2 3 0.5 1 1\n", "observation 1 of image 1, which has 1");
  expect(camera, "1 " + pose + "1 a.jpg\n\n", "1 0 0 0 1 2 300 0.5\n", "RGB 300 is too large");
}

TEST_F(ColmapTest, FoldersWithoutAModelAreErrors) {
  EXPECT_ERROR(read_sparse_model(path("nowhere")), "nowhere: no such folder");
  write("empty/readme", "");
  EXPECT_ERROR(read_sparse_model(path("empty")), "empty: not a COLMAP model");
}

TEST_F(ColmapTest, TruncatedBinaryModelsAreErrorsAtEveryLength) {
  write_sparse_model_binary(path("m"), awkward_model());
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    const std::string whole = read(std::string("m/") + name);
    for (size_t size = 0; size < whole.size(); size += 3) {
      write(std::string("m/") + name, whole.substr(0, size));
      EXPECT_ERROR(read_sparse_model(path("m")), "m/");
    }
    write(std::string("m/") + name, whole);
  }
  EXPECT_EQ(read_sparse_model(path("m")).images.size(), 20u);
}

TEST_F(ColmapTest, TextIsNotWrittenBesideABinaryModel) {
  write_sparse_model_binary(path("m"), awkward_model());
  EXPECT_ERROR(write_sparse_model_text(path("m"), awkward_model()), "holds a binary one");
}

TEST(ColmapSceneTest, EveryModelOfTheScenesIsRead) {
  if (!std::filesystem::exists(CPPLUS_DATA_DIR)) GTEST_SKIP() << CPPLUS_DATA_DIR << " is missing";
  size_t num_models = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(CPPLUS_DATA_DIR)) {
    if (entry.path().filename() != "images.txt") continue;
    EXPECT_GT(read_sparse_model(entry.path().parent_path().string()).images.size(), 0u) << entry.path();
    ++num_models;
  }
  EXPECT_GT(num_models, 10u);
}

}  // namespace
}  // namespace cpplus
