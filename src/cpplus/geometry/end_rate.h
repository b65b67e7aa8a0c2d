#pragma once

#include <Eigen/Core>

namespace cpplus {

/// Weights w of samples f(t_0), f(t_1), ... (at least four stamps, seconds, strictly ascending or descending) for which
/// sum_k w_k f(t_k) is the derivative f'(t_0), per second.
///
/// Knowing a motion from one side only, finite differences do badly: their error grows with the order once a motion has
/// fewer than 2 pi samples a period. These weights are exact for cubics, as finite differences are, and besides
/// minimise the mean squared error over all sinusoids of up to a fifth of the sampling rate: kriging of a band-limited
/// function with a cubic trend. Four samples give the derivative of the cubic through them.
Eigen::VectorXd end_rate_weights(const Eigen::VectorXd& stamps_s);

}  // namespace cpplus
