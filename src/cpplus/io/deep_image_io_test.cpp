#include "cpplus/io/deep_image_io.h"

#include <opencv2/imgcodecs.hpp>

#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using DeepImageTest = FileTest;

TEST_F(DeepImageTest, Png16KeepsEveryValue) {
  DeepImage image(3, 2);
  image.pixels = {0, 1, 255, 256, 4000, 65535};
  write_png16(path("a.png"), image);
  const cv::Mat back = cv::imread(path("a.png"), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(back.type(), CV_16UC1);
  ASSERT_EQ(back.cols, 3);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(back.at<uint16_t>(i / 3, i % 3), image.pixels[static_cast<size_t>(i)]);
}

TEST_F(DeepImageTest, Png16OfThreeChannelsIsRedGreenBlue) {
  DeepColorImage image(1, 1);
  image.pixels = {{100, 2000, 65535}};
  write_png16(path("a.png"), image);
  const cv::Mat back = cv::imread(path("a.png"), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(back.type(), CV_16UC3);
  EXPECT_EQ(back.at<cv::Vec3w>(0, 0), cv::Vec3w(65535, 2000, 100));  // OpenCV: blue first
}

TEST_F(DeepImageTest, ExrKeepsFloats) {
  Image<float> depth(2, 1);
  depth.pixels = {1.2345678f, 1e5f};
  Image<Eigen::Vector3f> normals(1, 1, Eigen::Vector3f(0.25f, -0.5f, 0.125f));
  write_exr(path("d.exr"), depth);
  write_exr(path("n.exr"), normals);
  const cv::Mat d = cv::imread(path("d.exr"), cv::IMREAD_UNCHANGED);
  const cv::Mat n = cv::imread(path("n.exr"), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(d.type(), CV_32FC1);
  EXPECT_EQ(d.at<float>(0, 0), 1.2345678f);
  EXPECT_EQ(d.at<float>(0, 1), 1e5f);
  ASSERT_EQ(n.type(), CV_32FC3);
  EXPECT_EQ(n.at<cv::Vec3f>(0, 0), cv::Vec3f(0.125f, -0.5f, 0.25f));
}

TEST_F(DeepImageTest, WhatCannotBeWrittenIsAnError) {
  EXPECT_ERROR(write_png16(path("a.png"), DeepImage()), "empty");
  write("file", "");
  EXPECT_ERROR(write_png16(path("file/a.png"), DeepImage(1, 1)), "file/a.png");
}

}  // namespace
}  // namespace cpplus
