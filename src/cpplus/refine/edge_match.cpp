#include "cpplus/refine/edge_match.h"

namespace cpplus {

int count_edges(const std::vector<EdgeMatch>& matches) {
  int count = 0;
  for (size_t i = 0; i < matches.size(); ++i) count += i == 0 || matches[i].edge != matches[i - 1].edge;
  return count;
}

Matrix6d edge_information(const std::vector<EdgeMatch>& matches, double loss_scale) {
  Matrix6d information = Matrix6d::Zero();
  for (const EdgeMatch& m : matches) {
    const double residual = m.normal.dot(m.projected.pixel - m.pixel) / m.sigma_px;
    const double robust = 1.0 / (1.0 + residual * residual / (loss_scale * loss_scale));
    const Eigen::Matrix<double, 1, 6> jacobian = m.normal.transpose() * m.projected.d_pixel_d_delta / m.sigma_px;
    information += robust * m.weight * jacobian.transpose() * jacobian;
  }
  return information;
}

}  // namespace cpplus
