#include "cpplus/refine/edge_match.h"

#include "cpplus/refine/direction_errors.h"

namespace cpplus {

int count_edges(const std::vector<EdgeMatch>& matches) {
  int count = 0;
  for (size_t i = 0; i < matches.size(); ++i) count += i == 0 || matches[i].edge != matches[i - 1].edge;
  return count;
}

Matrix6d edge_information(const std::vector<EdgeMatch>& matches, double loss_scale) {
  Matrix6d information = Matrix6d::Zero();
  DirectionErrors errors;
  for (const EdgeMatch& m : matches) {
    const double residual = m.normal.dot(m.projected.pixel - m.pixel) / m.sigma_px;
    const double robust = 1.0 / (1.0 + residual * residual / (loss_scale * loss_scale));
    const Eigen::Matrix<double, 1, 6> jacobian = m.normal.transpose() * m.projected.d_pixel_d_delta / m.sigma_px;
    information += robust * m.weight * jacobian.transpose() * jacobian;
    errors.add(m, m.projected.camera_from_map * m.x_in_map, m.projected.camera_from_map.rotation.toRotationMatrix(),
               robust * m.weight);
  }
  return errors.discounted(information);
}

}  // namespace cpplus
