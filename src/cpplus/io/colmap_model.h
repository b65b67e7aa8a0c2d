#pragma once

#include <Eigen/Core>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cpplus/geometry/sparse_model.h"

namespace cpplus {

/// What the text and the binary form of a COLMAP model share; pixels here are COLMAP's (top-left centre = (0.5, 0.5)).

/// A number to add to the parameters cx and cy; nothing changes for a model without a principal point.
void shift_principal_point(CameraModel model, double shift, std::vector<double>* params);

/// Index of an image's observation in its POINTS2D list.
struct TrackElement {
  uint32_t image_id = 0;
  uint32_t observation = 0;
};

/// Checks records as they come from a file, and puts a SparseModel together. `where` begins the error messages: the
/// file and the line or record.
class SparseModelBuilder {
 public:
  void add_camera(const std::string& where, uint32_t id, CameraModel model, uint64_t width, uint64_t height,
                  std::vector<double> params);
  /// pose = QW QX QY QZ TX TY TZ of camera_from_world; pixels = all of the image's POINTS2D.
  void add_image(const std::string& where, uint32_t id, const Eigen::Matrix<double, 7, 1>& pose, uint32_t camera_id,
                 const std::string& name, std::vector<Eigen::Vector2d> pixels);
  void add_point(const std::string& where, uint64_t id, const Eigen::Vector3d& position, const Rgb& color,
                 double error_px, const std::vector<TrackElement>& track);
  SparseModel take() { return std::move(model_); }

 private:
  SparseModel model_;
  std::set<std::string> names_;
  std::set<uint64_t> point_ids_;
  std::map<uint32_t, std::vector<Eigen::Vector2d>> pixels_;
};

/// The observations of each image in the order of POINTS2D, and the index of each track element in it.
struct ObservationLists {
  struct Observation {
    Eigen::Vector2d pixel;
    uint64_t point_id = 0;
  };
  std::map<uint32_t, std::vector<Observation>> of_image;
  std::vector<std::vector<TrackElement>> tracks;  // one a point, in the order of model.points
};
ObservationLists list_observations(const SparseModel& model);

SparseModel read_sparse_model_text(const std::string& directory);
SparseModel read_sparse_model_binary(const std::string& directory);

}  // namespace cpplus
