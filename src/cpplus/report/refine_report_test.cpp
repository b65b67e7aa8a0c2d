#include "cpplus/report/refine_report.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace cpplus {
namespace {

ImageReport image_report() {
  ImageReport image;
  image.name = "a \"quoted\" name.jpg";
  image.status = ImageStatus::kRefined;
  image.num_map_edges = 7;
  image.sharpness = 2.5;
  image.milliseconds = {{"decode", 3.0}, {"refine", 4.5}};
  RefinePoseResult& r = image.refine;
  r.before.median_px = 4.0;
  r.after.rms_px = 0.75;
  r.after.inlier_share = 0.9;
  r.held_out_after.num_samples = 12;
  r.num_samples = 100;
  r.num_matches = 80;
  r.num_edges = 6;
  r.iterations = 9;
  r.covariance.diagonal() << 1, 2, 3, 4, 5, 6;
  r.covariance(0, 5) = r.covariance(5, 0) = 0.5;
  r.information_eigenvalues << 0.5, 2, 3, 4, 5, 6;
  r.weak_directions = {"translation z"};
  r.predicted_shift_px = 0.8;
  image.surfaces = {40, 7.0, 0.4};
  image.intensities = {12, 6.0, 0.5};
  return image;
}

TEST(RefineReport, HoldsTheFiguresUnderTheirNames) {
  MapReport map;
  map.path = "map.las";
  map.num_points = 12345;
  map.noise_m = 0.02;
  const auto json = nlohmann::json::parse(
      refine_report_json({"/d/map.las", "/d/photos", "/d/coarse"}, map, {}, {image_report()}, {}));
  EXPECT_FALSE(json["version"].get<std::string>().empty());
  EXPECT_EQ(json["inputs"]["map"], "/d/map.las");
  EXPECT_EQ(json["inputs"]["images"], "/d/photos");
  EXPECT_EQ(json["inputs"]["poses"], "/d/coarse");
  EXPECT_EQ(json["map"]["points"], 12345);
  EXPECT_EQ(json["map"]["noise_m"], 0.02);
  ASSERT_EQ(json["images"].size(), 1u);
  const auto& image = json["images"][0];
  EXPECT_EQ(image["name"], "a \"quoted\" name.jpg");
  EXPECT_EQ(image["status"], "refined");
  EXPECT_EQ(image["reason"], "");
  EXPECT_EQ(image["before"]["median_px"], 4.0);
  EXPECT_EQ(image["after"]["rms_px"], 0.75);
  EXPECT_EQ(image["after"]["inlier_share"], 0.9);
  EXPECT_EQ(image["held_out_after"]["samples"], 12);
  EXPECT_EQ(image["map_edges"], 7);
  EXPECT_EQ(image["samples"], 100);
  EXPECT_EQ(image["matches"], 80);
  EXPECT_EQ(image["iterations"], 9);
  EXPECT_EQ(image["milliseconds"]["decode"], 3.0);
  EXPECT_EQ(image["milliseconds"]["total"], 7.5);
  EXPECT_EQ(image["covariance"][4][4], 5.0);
  EXPECT_EQ(image["covariance"][0][5], 0.5);
  EXPECT_EQ(image["eigenvalues"][0], 0.5);
  EXPECT_EQ(image["weak_directions"], nlohmann::json::array({"translation z"}));
  EXPECT_EQ(image["predicted_shift_px"], 0.8);
  EXPECT_EQ(image["surfaces"]["matches"], 40);
  EXPECT_EQ(image["surfaces"]["before_median_px"], 7.0);
  EXPECT_EQ(image["surfaces"]["after_median_px"], 0.4);
  EXPECT_EQ(image["intensities"]["matches"], 12);
  EXPECT_EQ(image["intensities"]["before_median_px"], 6.0);
  EXPECT_EQ(image["intensities"]["after_median_px"], 0.5);
}

TEST(RefineReport, TimesOfAStageThatWasGoneThroughTwiceAreOne) {
  ImageReport image;
  image.milliseconds = {{"decode", 3.0}, {"joint_view", 2.0}, {"joint_view", 4.5}};
  const auto json = nlohmann::json::parse(refine_report_json({}, {}, {}, {image}, {}));
  EXPECT_EQ(json["images"][0]["milliseconds"], (nlohmann::json{{"decode", 3.0}, {"joint_view", 6.5}, {"total", 9.5}}));
}

TEST(RefineReport, TheRangeScaleIsThereWhereItWasSolvedFor) {
  std::map<uint32_t, SharedErrors> shared;
  shared[3].range_scale = Estimate{-0.006, 0.001};
  shared[4] = SharedErrors();
  const auto json = nlohmann::json::parse(refine_report_json({}, {}, shared, {}, {}));
  EXPECT_EQ(json["shared"]["3"]["range_scale"], -0.006);
  EXPECT_EQ(json["shared"]["3"]["range_scale_sigma"], 0.001);
  EXPECT_FALSE(json["shared"]["4"].contains("range_scale"));
}

TEST(RefineReport, NumbersThatDoNotExistAreNull) {
  ImageReport image = image_report();
  image.refine.after.median_px = std::numeric_limits<double>::quiet_NaN();
  image.refine.covariance(2, 2) = std::numeric_limits<double>::infinity();
  const auto json = nlohmann::json::parse(refine_report_json({}, {}, {}, {image}, {}));
  EXPECT_TRUE(json["images"][0]["after"]["median_px"].is_null());
  EXPECT_TRUE(json["images"][0]["covariance"][2][2].is_null());
}

TEST(RefineReport, EachStatusHasTheNameOfTheContract) {
  EXPECT_EQ(status_name(ImageStatus::kRefined), "refined");
  EXPECT_EQ(status_name(ImageStatus::kKeptCoarse), "kept_coarse");
  EXPECT_EQ(status_name(ImageStatus::kBlurred), "blurred");
  EXPECT_EQ(status_name(ImageStatus::kOutsideMap), "outside_map");
  EXPECT_EQ(status_name(ImageStatus::kUnreadable), "unreadable");
}

TEST(RefineReport, WithoutImagesTheListIsEmpty) {
  const auto json = nlohmann::json::parse(refine_report_json({}, {}, {}, {}, {}));
  EXPECT_TRUE(json["images"].is_array());
  EXPECT_TRUE(json["images"].empty());
  EXPECT_TRUE(json["shared"].is_object());
}

}  // namespace
}  // namespace cpplus
