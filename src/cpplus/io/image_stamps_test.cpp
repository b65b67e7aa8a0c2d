#include "cpplus/io/image_stamps.h"

#include "cpplus/io/test_files.h"

namespace cpplus {
namespace {

using ImageStamps = FileTest;

TEST_F(ImageStamps, WholeNumbersGoByTheirDigits) {
  EXPECT_EQ(parse_stamp("1403636579.25", StampUnit::kAuto), 1403636579.25);
  EXPECT_EQ(parse_stamp("1403636579", StampUnit::kAuto), 1403636579.0);
  EXPECT_EQ(parse_stamp("1403636579250", StampUnit::kAuto), 1403636579.25);
  EXPECT_EQ(parse_stamp("1403636579250000", StampUnit::kAuto), 1403636579.25);
  EXPECT_NEAR(*parse_stamp("1403636579763555584", StampUnit::kAuto), 1403636579.763555584, 2e-7);
  EXPECT_EQ(parse_stamp("2500000000", StampUnit::kNanoseconds), 2.5) << "a clock that counts from its start";
  EXPECT_FALSE(parse_stamp("nan", StampUnit::kAuto));
  EXPECT_FALSE(parse_stamp("12a", StampUnit::kAuto));
  EXPECT_FALSE(parse_stamp("", StampUnit::kAuto));
}

TEST_F(ImageStamps, FileNames) {
  EXPECT_EQ(stamp_of_file_name("1305031102.175304.png", StampUnit::kAuto), 1305031102.175304);
  EXPECT_EQ(stamp_of_file_name("cam0/data/1403636579250000000.jpg", StampUnit::kAuto), 1403636579.25);
  EXPECT_EQ(stamp_of_file_name("cam0_1661398632.5_2.png", StampUnit::kAuto), 1661398632.5);
  EXPECT_EQ(stamp_of_file_name("1661398632_250000000.png", StampUnit::kAuto), 1661398632.25);
  EXPECT_EQ(stamp_of_file_name("frame_000012.png", StampUnit::kAuto), 12.0);
  EXPECT_FALSE(stamp_of_file_name("photo.png", StampUnit::kAuto));
  EXPECT_TRUE(may_be_frame_number("frame_000012.png"));
  EXPECT_FALSE(may_be_frame_number("12.5.png"));
  EXPECT_FALSE(may_be_frame_number("1403636579.png"));
}

TEST_F(ImageStamps, EitherOrderAndCsv) {
  const auto expect_two = [&](const std::string& text) {
    const auto stamps = read_image_stamps(write("s.txt", text), StampUnit::kAuto);
    ASSERT_EQ(stamps.size(), 2u) << text;
    EXPECT_EQ(stamps.at("a.png"), 10.5) << text;
    EXPECT_EQ(stamps.at("my b.png"), 11.0) << text;
  };
  expect_two("# name seconds\na.png 10.5\nmy b.png 11\n");
  expect_two("10.5 a.png\n11 my b.png\n");
  expect_two("name,stamp,exposure\na.png,10.5,0.01\nmy b.png,11,0.01\n");
  const auto euroc = read_image_stamps(
      write("data.csv", "#timestamp [ns],filename\r\n1403636579250000000,1403636579250000000.png\r\n"),
      StampUnit::kAuto);
  EXPECT_EQ(euroc.at("1403636579250000000.png"), 1403636579.25);
}

TEST_F(ImageStamps, BadLinesAreErrorsThatNameThem) {
  const auto expect = [&](const std::string& text, const std::string& message) {
    EXPECT_ERROR(read_image_stamps(write("s.txt", text), StampUnit::kAuto), message);
  };
  expect("# nothing\n", "s.txt: holds no stamps");
  expect("a.png 1\nb.png now\n", "s.txt:2: not a name and a stamp: 'b.png now'");
  expect("a.png,1\n3,2\n", "s.txt:2: not a name and a stamp: '3,2'");
  expect("a.png 1\na.png 2\n", "s.txt:2: 'a.png' occurs twice");
}

}  // namespace
}  // namespace cpplus
