#include "cpplus/io/image_io.h"

#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using ImageIoTest = FileTest;

ColorImage ramp(int width, int height) {
  ColorImage image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.at(x, y) = {static_cast<uint8_t>(3 * x), static_cast<uint8_t>(5 * y), static_cast<uint8_t>(x + y)};
    }
  }
  return image;
}

cv::Mat to_bgr(const ColorImage& image) {
  cv::Mat bgr(image.height, image.width, CV_8UC3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Rgb& rgb = image.at(x, y);
      bgr.at<cv::Vec3b>(y, x) = {rgb[2], rgb[1], rgb[0]};
    }
  }
  return bgr;
}

std::string encoded(const std::string& extension, const cv::Mat& image) {
  std::vector<uint8_t> bytes;
  cv::imencode(extension, image, bytes);
  return {bytes.begin(), bytes.end()};
}

TEST_F(ImageIoTest, PngComesBackExactly) {
  const ColorImage image = ramp(37, 21);
  write_png(path("a.png"), image);
  const ColorImage back = read_color_image(path("a.png"));
  EXPECT_EQ(back.width, 37);
  EXPECT_EQ(back.height, 21);
  EXPECT_EQ(back.pixels, image.pixels);
  EXPECT_EQ(read_gray_image(path("a.png")).pixels.size(), image.pixels.size());
}

TEST_F(ImageIoTest, GrayWeightsByHand) {
  ColorImage image(4, 1);
  image.pixels = {Rgb{255, 0, 0}, Rgb{0, 255, 0}, Rgb{0, 0, 255}, Rgb{255, 255, 255}};
  EXPECT_THAT(to_gray(image).pixels, testing::ElementsAre(76, 150, 29, 255));
}

TEST_F(ImageIoTest, GrayAgreesWithOpenCv) {
  const ColorImage image = ramp(80, 50);
  cv::Mat gray;
  cv::cvtColor(to_bgr(image), gray, cv::COLOR_BGR2GRAY);
  const GrayImage ours = to_gray(image);
  for (size_t i = 0; i < ours.pixels.size(); ++i) ASSERT_NEAR(ours.pixels[i], gray.data[i], 1);
}

TEST_F(ImageIoTest, JpegDecodesAsOpenCvDoes) {
  const cv::Mat bgr = to_bgr(ramp(81, 51));
  write("a.jpg", encoded(".jpg", bgr));
  const cv::Mat color = cv::imread(path("a.jpg"), cv::IMREAD_COLOR);
  const cv::Mat gray = cv::imread(path("a.jpg"), cv::IMREAD_GRAYSCALE);
  const ColorImage our_color = read_color_image(path("a.jpg"));
  const GrayImage our_gray = read_gray_image(path("a.jpg"));
  ASSERT_EQ(our_color.width, 81);
  ASSERT_EQ(our_gray.height, 51);
  for (int y = 0; y < 51; ++y) {
    for (int x = 0; x < 81; ++x) {
      ASSERT_EQ(our_gray.at(x, y), gray.at<uint8_t>(y, x));
      for (int c = 0; c < 3; ++c)
        ASSERT_EQ(our_color.at(x, y)[static_cast<size_t>(c)], color.at<cv::Vec3b>(y, x)[2 - c]);
    }
  }
}

TEST_F(ImageIoTest, ExifOrientationIsIgnored) {
  // An APP1 segment with one tag, Orientation = 6 (rotate by 90 degrees), put after the start-of-image marker.
  const std::string exif = std::string("\xFF\xE1\x00\x22", 4) + std::string("Exif\0\0", 6) +
                           std::string("MM\0\x2A\0\0\0\x08", 8) + std::string("\0\x01", 2) +
                           std::string("\x01\x12\0\x03\0\0\0\x01\0\x06\0\0", 12) + std::string("\0\0\0\0", 4);
  std::string bytes = encoded(".jpg", to_bgr(ramp(40, 20)));
  bytes.insert(2, exif);
  write("turned.jpg", bytes);
  ASSERT_EQ(cv::imread(path("turned.jpg"), cv::IMREAD_COLOR).cols, 20) << "the orientation tag is not well made";
  EXPECT_EQ(read_color_image(path("turned.jpg")).width, 40);
  EXPECT_EQ(read_gray_image(path("turned.jpg")).width, 40);
  EXPECT_EQ(read_image_size(path("turned.jpg")).width, 40);
}

TEST_F(ImageIoTest, BrokenOffAndDamagedImagesAreErrors) {
  const cv::Mat bgr = to_bgr(ramp(200, 150));
  for (const std::string extension : {".jpg", ".png"}) {
    const std::string whole = encoded(extension, bgr);
    for (const double share : {0.0, 0.01, 0.3, 0.6, 0.95}) {
      const std::string name = "cut" + extension;
      write(name, whole.substr(0, static_cast<size_t>(share * static_cast<double>(whole.size()))));
      EXPECT_ERROR(read_color_image(path(name)), path(name));
      EXPECT_ERROR(read_gray_image(path(name)), path(name));
    }
  }
  std::string damaged = encoded(".jpg", bgr);
  for (size_t i = damaged.size() / 2; i < damaged.size() / 2 + 60; ++i) damaged[i] = '\xFF';
  write("damaged.jpg", damaged);
  EXPECT_ERROR(read_color_image(path("damaged.jpg")), "damaged.jpg: corrupt JPEG");
  std::string damaged_png = encoded(".png", bgr);
  damaged_png[damaged_png.size() / 2] ^= 1;
  EXPECT_ERROR(read_color_image(write("damaged.png", damaged_png)), "damaged.png: corrupt PNG: wrong checksum");
  EXPECT_ERROR(read_color_image(write("text.jpg", "this is no image")), "text.jpg: not an image");
  EXPECT_ERROR(read_color_image(path("none.jpg")), "none.jpg: cannot read");
}

TEST_F(ImageIoTest, BytesAfterTheEndOfTheImageDoNoHarm) {
  write("a.jpg", encoded(".jpg", to_bgr(ramp(40, 20))) + std::string(1000, 'x'));
  EXPECT_EQ(read_color_image(path("a.jpg")).width, 40);
}

TEST_F(ImageIoTest, WritingWhereThereIsNoWayIsAnError) {
  EXPECT_ERROR(write_png("/proc/a.png", ramp(4, 4)), "/proc/a.png: cannot write");
  EXPECT_ERROR(write_png(path("a.png"), ColorImage()), "the image is empty");
}

}  // namespace
}  // namespace cpplus
