#include "cpplus/report/report_page.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cpplus/core/error.h"
#include "cpplus/report/refine_report.h"
#include "cpplus/report/view_page.h"

namespace cpplus {
namespace {

// One camera that looks along +x of the map, z up; moved by 0.3 m to the right and turned by 2 degrees.
struct Case {
  SparseModel coarse, refined;
  std::string report_json;
};

Case make_case() {
  Case c;
  c.coarse.cameras[1] = Camera(CameraModel::kPinhole, 100, 80, {50, 50, 49.5, 39.5});
  Eigen::Matrix3d camera_from_map;
  camera_from_map << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  PosedImage image;
  image.name = "a.jpg";
  image.camera_id = 1;
  image.camera_from_map = Rigid3(camera_from_map, camera_from_map * Eigen::Vector3d(-10, -20, -1));  // at (10, 20, 1)
  c.coarse.images = {image};
  Vector6d moved;
  moved << 0, 0, 2 * EIGEN_PI / 180, 0.3, 0, 0;
  image.camera_from_map = perturb_camera(image.camera_from_map, moved);
  c.refined = c.coarse;
  c.refined.images = {image};
  ImageReport report;
  report.name = "a.jpg";
  report.status = ImageStatus::kRefined;
  report.refine.predicted_shift_px = 0.5;
  report.refine.covariance.diagonal() << 1e-6, 1e-6, 1e-6, 0.04, 0.01, 0.09;  // z, where it looks, is known worst
  c.report_json = refine_report_json({}, {}, {}, {report}, {});
  return c;
}

nlohmann::json parse_script(const std::string& script, const std::string& variable) {
  const std::string head = "window." + variable + " = ";
  EXPECT_EQ(script.substr(0, head.size()), head);
  return nlohmann::json::parse(script.substr(head.size(), script.size() - head.size() - 2));
}

TEST(ReportPage, PlacesMovesAndEllipsesAreInTheTopView) {
  const Case c = make_case();
  ReportPage page;
  page.report_json = c.report_json;
  page.coarse = c.coarse;
  page.refined = c.refined;
  page.has_pictures = {true};
  const auto image = parse_script(report_page_script(page), "cpplusReport")["images"][0];
  EXPECT_EQ(image["at_before"], nlohmann::json({10.0, 20.0}));
  EXPECT_NEAR(image["at_after"][0].get<double>(), 10.0, 1e-4);
  EXPECT_NEAR(image["at_after"][1].get<double>(), 19.7, 1e-4);  // the camera's right is the map's -y
  EXPECT_NEAR(image["looks"][0].get<double>(), 1.0, 1e-4);
  EXPECT_NEAR(image["moved_m"].get<double>(), 0.3, 1e-6);
  EXPECT_NEAR(image["moved_deg"].get<double>(), 2.0, 1e-6);
  EXPECT_NEAR(image["ellipse"][0].get<double>(), 0.3, 1e-3);
  EXPECT_NEAR(image["ellipse"][1].get<double>(), 0.2, 1e-3);
  EXPECT_NEAR(std::abs(std::cos(image["ellipse"][2].get<double>())), 1.0, 1e-3);  // along x
  EXPECT_EQ(image["pictures"][0], "pictures/000000_thumbnail.jpg");
}

TEST(ReportPage, AReportThatIsNoneIsAnError) {
  ReportPage page;
  page.report_json = "{}";
  EXPECT_THROW(report_page_script(page), Error);
  page.report_json = "no json";
  EXPECT_THROW(report_page_script(page), Error);
}

TEST(ViewPage, PosesAreMapFromCameraAndRaysThoseOfTheCamera) {
  const Case c = make_case();
  ViewPage page;
  page.report_json = c.report_json;
  page.coarse = c.coarse;
  page.origin_in_map = {9, 18, 0};
  const auto view = parse_script(view_page_script(page), "cpplusView");
  const auto pose = view["images"][0]["coarse"];
  for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(pose[4 + i].get<double>(), (std::vector<double>{1, 2, 1})[i], 1e-4);
  const Eigen::Quaterniond q(pose[3].get<double>(), pose[0].get<double>(), pose[1].get<double>(),
                             pose[2].get<double>());
  EXPECT_NEAR((q * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(), 0.0, 1e-5);
  EXPECT_EQ(view["images"][0]["refined"], pose);  // the refined model does not name it

  const auto grid = view["cameras"]["1"];
  EXPECT_EQ(grid["columns"], 33);
  // The top left corner of the image is 50 px left of and 40 px above the principal point, at a focal length of 50 px.
  const Eigen::Vector3d corner(grid["bearings"][0], grid["bearings"][1], grid["bearings"][2]);
  EXPECT_NEAR((corner / corner.z() - Eigen::Vector3d(-1.0, -0.8, 1.0)).norm(), 0.0, 1e-4);
}

}  // namespace
}  // namespace cpplus
