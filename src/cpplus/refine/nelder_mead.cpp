#include "cpplus/refine/nelder_mead.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace cpplus {
namespace {

constexpr int kDimensions = 6;

struct Corner {
  Vector6d x = Vector6d::Zero();  // in steps from the start
  double cost = 0.0;
};

class Simplex {
 public:
  Simplex(const std::function<double(const Vector6d&)>& cost, const Vector6d& start, const Vector6d& steps)
      : cost_(cost), start_(start), steps_(steps) {
    corners_[0] = corner_at(Vector6d::Zero());
    for (int i = 0; i < kDimensions; ++i) corners_[static_cast<size_t>(i + 1)] = corner_at(Vector6d::Unit(i));
    sort();
  }

  /// Replaces the worst corner, or shrinks the simplex to the best one.
  void step() {
    Corner& worst = corners_.back();
    const Vector6d middle = mean_without_worst();
    const Corner reflected = corner_at(2.0 * middle - worst.x);
    if (reflected.cost < corners_.front().cost) {
      const Corner expanded = corner_at(3.0 * middle - 2.0 * worst.x);
      worst = expanded.cost < reflected.cost ? expanded : reflected;
    } else if (reflected.cost < corners_[kDimensions - 1].cost) {
      worst = reflected;
    } else {
      const Corner& nearer = reflected.cost < worst.cost ? reflected : worst;
      const Corner contracted = corner_at(0.5 * (middle + nearer.x));
      if (contracted.cost < nearer.cost) {
        worst = contracted;
      } else {
        shrink();
      }
    }
    sort();
  }

  double size() const {
    double size = 0.0;
    for (const Corner& corner : corners_) size = std::max(size, (corner.x - corners_[0].x).cwiseAbs().maxCoeff());
    return size;
  }

  NelderMeadResult best() const { return {value(corners_[0].x), corners_[0].cost, evaluations_}; }
  int evaluations() const { return evaluations_; }

 private:
  Vector6d value(const Vector6d& x) const { return start_ + steps_.cwiseProduct(x); }

  Corner corner_at(const Vector6d& x) {
    ++evaluations_;
    const double cost = cost_(value(x));
    return {x, std::isnan(cost) ? std::numeric_limits<double>::infinity() : cost};
  }

  Vector6d mean_without_worst() const {
    Vector6d sum = Vector6d::Zero();
    for (size_t i = 0; i < kDimensions; ++i) sum += corners_[i].x;
    return sum / kDimensions;
  }

  void shrink() {
    for (size_t i = 1; i < corners_.size(); ++i) corners_[i] = corner_at(0.5 * (corners_[0].x + corners_[i].x));
  }

  // Stable: of equal corners the older one counts as the better one.
  void sort() {
    std::stable_sort(corners_.begin(), corners_.end(),
                     [](const Corner& a, const Corner& b) { return a.cost < b.cost; });
  }

  const std::function<double(const Vector6d&)>& cost_;
  const Vector6d start_;
  const Vector6d steps_;
  int evaluations_ = 0;
  std::array<Corner, kDimensions + 1> corners_;  // best first
};

}  // namespace

NelderMeadResult minimise_nelder_mead(const std::function<double(const Vector6d&)>& cost, const Vector6d& start,
                                      const Vector6d& steps, const NelderMeadOptions& options) {
  Simplex simplex(cost, start, steps);
  while (simplex.evaluations() < options.max_evaluations && simplex.size() > options.min_size) simplex.step();
  return simplex.best();
}

}  // namespace cpplus
