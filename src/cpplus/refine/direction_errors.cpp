#include "cpplus/refine/direction_errors.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace cpplus {
namespace {

// Information counts for what it exceeds so many times of what the errors feign: their size is known by half.
constexpr double kTimesFeigned = 3.0;
// Keeps the information of too few edges invertible.
constexpr double kRidge = 1e-12;

// The directions in which information and feigned information are independent, those of the former having length 1.
struct Directions {
  Matrix6d from_unit;  // columns
  Matrix6d to_unit;
  Vector6d trusted;  // share of the information that is more than feigned

  Directions(const Matrix6d& information, const Matrix6d& feigned) {
    const Matrix6d ridge = kRidge * information.trace() * Matrix6d::Identity();
    const Matrix6d root = (information + ridge).llt().matrixL();
    const Matrix6d inverse_root = root.triangularView<Eigen::Lower>().solve(Matrix6d::Identity());
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(inverse_root * feigned * inverse_root.transpose());
    from_unit = root * eigen.eigenvectors();
    to_unit = eigen.eigenvectors().transpose() * inverse_root;
    trusted = (Vector6d::Ones() - kTimesFeigned * eigen.eigenvalues()).cwiseMax(0.0).cwiseMin(1.0);
  }
};

}  // namespace

void DirectionErrors::add(const EdgeMatch& match, const Eigen::Vector3d& x_in_camera,
                          const Eigen::Matrix3d& camera_from_map, double weight) {
  const Eigen::RowVector3d slip = (camera_from_map * match.slip_in_map / match.sigma_px).transpose();
  const Eigen::Matrix<double, 1, 6> q = slip * d_camera_point_d_delta(x_in_camera);
  information_.noalias() += weight * q.transpose() * q;
}

void DirectionErrors::discount(Eigen::MatrixXd* h, Eigen::VectorXd* g, double* cost) const {
  const Matrix6d information = h->topLeftCorner<6, 6>();
  if (!(information_.trace() > 0.0) || !(information.trace() > 0.0)) return;
  const Directions directions(information, information_);
  const Vector6d unit_gradient = directions.to_unit * g->head<6>();
  *cost -= (Vector6d::Ones() - directions.trusted).dot(unit_gradient.cwiseAbs2());
  g->head<6>() = directions.from_unit * directions.trusted.cwiseProduct(unit_gradient);
  h->topLeftCorner<6, 6>() = directions.from_unit * directions.trusted.asDiagonal() * directions.from_unit.transpose();
  const Eigen::Index others = h->cols() - 6;
  if (others == 0) return;
  const Eigen::MatrixXd mixed = directions.from_unit * directions.trusted.cwiseSqrt().asDiagonal() *
                                directions.to_unit * h->topRightCorner(6, others);
  h->topRightCorner(6, others) = mixed;
  h->bottomLeftCorner(others, 6) = mixed.transpose();
}

Matrix6d DirectionErrors::discounted(const Matrix6d& information) const {
  Eigen::MatrixXd h = information;
  Eigen::VectorXd g = Vector6d::Zero();
  double cost = 0.0;
  discount(&h, &g, &cost);
  return h;
}

}  // namespace cpplus
