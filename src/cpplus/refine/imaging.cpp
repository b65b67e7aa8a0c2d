#include "cpplus/refine/imaging.h"

namespace cpplus {
namespace {

// Steps of numerical derivatives, in prior sigmas.
constexpr double kStepSigmas = 1e-3;

// Standard deviations of all parameters of a camera.
std::vector<double> intrinsics_sigmas(const Camera& camera, const ImagingOptions& options) {
  const auto principal_point = camera_model_principal_point_index(camera.model());
  std::vector<double> sigmas;
  for (size_t k = 0; k < camera.params().size(); ++k) {
    if (!principal_point || k < *principal_point) {
      sigmas.push_back(options.focal_sigma_ratio * camera.params()[k]);
    } else {
      sigmas.push_back(k < *principal_point + 2 ? options.principal_point_sigma_px : options.distortion_sigma);
    }
  }
  return sigmas;
}

}  // namespace

void ImagingOptions::validate() const {
  check_option(readout_sigma_s >= 0, "readout_sigma_s", "[0, inf)", readout_sigma_s);
  check_option(focal_sigma_ratio > 0, "focal_sigma_ratio", "(0, inf)", focal_sigma_ratio);
  check_option(principal_point_sigma_px > 0, "principal_point_sigma_px", "(0, inf)", principal_point_sigma_px);
  check_option(distortion_sigma > 0, "distortion_sigma", "(0, inf)", distortion_sigma);
}

Imaging::Imaging(const Camera& camera, bool has_velocities, const ImagingOptions& options)
    : camera_(camera), has_readout_(has_velocities && options.readout_sigma_s > 0) {
  std::vector<double> values, sigmas;
  if (has_readout_) {
    values.push_back(0.0);
    sigmas.push_back(options.readout_sigma_s);
  }
  if (options.intrinsics && camera_model_principal_point_index(camera.model())) {
    values.insert(values.end(), camera.params().begin(), camera.params().end());
    for (const double sigma : intrinsics_sigmas(camera, options)) {
      sigmas.push_back(sigma);
      steps_.push_back(kStepSigmas * sigma);
    }
  }
  values_ = Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  prior_sigmas_ = Eigen::Map<Eigen::VectorXd>(sigmas.data(), static_cast<Eigen::Index>(sigmas.size()));
  prior_means_ = values_;
  update_cameras();
}

void Imaging::set_values(const Eigen::VectorXd& values) {
  values_ = values;
  update_cameras();
}

void Imaging::update_cameras() {
  if (steps_.empty()) return;
  const Eigen::Index first = has_readout_ ? 1 : 0;
  const std::vector<double> params(values_.data() + first, values_.data() + values_.size());
  const auto with = [&](const std::vector<double>& changed) {
    return Camera(camera_.model(), camera_.width(), camera_.height(), changed);
  };
  neighbors_.clear();
  for (size_t k = 0; k < params.size(); ++k) {
    std::vector<double> lower = params;
    std::vector<double> higher = params;
    lower[k] -= steps_[k];
    higher[k] += steps_[k];
    neighbors_.push_back({with(lower), with(higher)});
  }
  camera_ = with(params);
}

}  // namespace cpplus
