#include "cpplus/features/image_gradient.h"

#include <array>
#include <cassert>
#include <cmath>

#include "cpplus/core/vector_clones.h"

namespace cpplus {
namespace {

constexpr double kSobelGain = 8.0;
constexpr double kBlurGain = ImageGradient::kUnitsPerLevel / kSobelGain;

// Weights of a Gaussian blur for distances 0 ... radius; all 2 radius + 1 together weigh `sum`.
std::vector<float> gaussian_weights(double sigma_px, double sum) {
  const int radius = static_cast<int>(std::ceil(3.0 * sigma_px));
  std::vector<double> weights;
  double total = 0.0;
  for (int k = 0; k <= radius; ++k) {
    weights.push_back(std::exp(-0.5 * k * k / (sigma_px * sigma_px)));
    total += (k > 0 ? 2.0 : 1.0) * weights.back();
  }
  std::vector<float> scaled;
  for (const double weight : weights) scaled.push_back(static_cast<float>(weight * sum / total));
  return scaled;
}

// Places before the first and behind the last one are mirrored at these, which are not repeated.
int mirrored(int place, int count) {
  if (count == 1) return 0;
  while (place < 0 || place >= count) place = place < 0 ? -place : 2 * (count - 1) - place;
  return place;
}

CPPLUS_VECTOR_CLONES void weigh(const float* __restrict in, float weight, int count, float* __restrict out) {
  for (int i = 0; i < count; ++i) out[i] = weight * in[i];
}

CPPLUS_VECTOR_CLONES void add_pair(const float* __restrict a, const float* __restrict b, float weight, int count,
                                   float* __restrict out) {
  for (int i = 0; i < count; ++i) out[i] += weight * (a[i] + b[i]);
}

CPPLUS_VECTOR_CLONES void to_float(const uint8_t* __restrict in, int count, float* __restrict out) {
  for (int i = 0; i < count; ++i) out[i] = in[i];
}

// Of numbers that are not negative.
CPPLUS_VECTOR_CLONES void round_to_int16(const float* __restrict in, int count, int16_t* __restrict out) {
  for (int i = 0; i < count; ++i) out[i] = static_cast<int16_t>(in[i] + 0.5f);
}

// Rows of a blurred image in fixed point, from the top downwards.
class BlurredRows {
 public:
  BlurredRows(const GrayImage& image, double sigma_px)
      : image_(image),
        weights_(gaussian_weights(sigma_px, std::sqrt(kBlurGain))),
        radius_(static_cast<int>(weights_.size()) - 1),
        padded_(static_cast<size_t>(image.width + 2 * radius_)),
        sum_(static_cast<size_t>(image.width)),
        rows_(weights_.size() * 2 - 1, std::vector<float>(static_cast<size_t>(image.width))) {}

  // Row y after row y - 1.
  void blur(int y, int16_t* out) {
    for (; next_ < image_.height && next_ <= y + radius_; ++next_) blur_along(next_);
    weigh(row(y), weights_[0], image_.width, sum_.data());
    for (int k = 1; k <= radius_; ++k) {
      add_pair(row(y - k), row(y + k), weights_[static_cast<size_t>(k)], image_.width, sum_.data());
    }
    round_to_int16(sum_.data(), image_.width, out);
  }

 private:
  float* row(int y) { return rows_[static_cast<size_t>(mirrored(y, image_.height)) % rows_.size()].data(); }

  void blur_along(int y) {
    float* in = padded_.data() + radius_;
    to_float(&image_.at(0, y), image_.width, in);
    for (int k = 1; k <= radius_; ++k) {
      in[-k] = in[mirrored(-k, image_.width)];
      in[image_.width - 1 + k] = in[mirrored(image_.width - 1 + k, image_.width)];
    }
    float* out = row(y);
    weigh(in, weights_[0], image_.width, out);
    for (int k = 1; k <= radius_; ++k) {
      add_pair(in - k, in + k, weights_[static_cast<size_t>(k)], image_.width, out);
    }
  }

  const GrayImage& image_;
  std::vector<float> weights_;
  int radius_;
  std::vector<float> padded_;
  std::vector<float> sum_;
  int next_ = 0;                          // of the rows to be blurred along themselves
  std::vector<std::vector<float>> rows_;  // blurred along themselves, by turns
};

// Sobel's differences of a row, whose own and whose neighbours' ends reach one pixel farther.
CPPLUS_VECTOR_CLONES void differences(const int16_t* __restrict above, const int16_t* __restrict here,
                                      const int16_t* __restrict below, int width, int16_t* __restrict dx,
                                      int16_t* __restrict dy) {
  for (int x = 0; x < width; ++x) {
    const int left = above[x - 1] + 2 * here[x - 1] + below[x - 1];
    const int right = above[x + 1] + 2 * here[x + 1] + below[x + 1];
    const int top = above[x - 1] + 2 * above[x] + above[x + 1];
    const int bottom = below[x - 1] + 2 * below[x] + below[x + 1];
    dx[x] = static_cast<int16_t>(right - left);
    dy[x] = static_cast<int16_t>(bottom - top);
  }
}

}  // namespace

ImageGradient blurred_gradient(const GrayImage& image, double sigma_px) {
  assert(!image.empty());
  const int width = image.width;
  const int height = image.height;
  ImageGradient gradient;
  gradient.width = width;
  gradient.height = height;
  gradient.dx.resize(image.pixels.size());
  gradient.dy.resize(image.pixels.size());

  BlurredRows blurred(image, sigma_px);
  std::array<std::vector<int16_t>, 3> rows;  // by turns, with a pixel more at either end
  for (std::vector<int16_t>& row : rows) row.resize(static_cast<size_t>(width) + 2);
  const auto row = [&](int y) { return rows[static_cast<size_t>(mirrored(y, height)) % 3].data() + 1; };
  const auto prepare = [&](int y) {
    blurred.blur(y, row(y));
    row(y)[-1] = row(y)[mirrored(-1, width)];
    row(y)[width] = row(y)[mirrored(width, width)];
  };
  prepare(0);
  for (int y = 0; y < height; ++y) {
    if (y + 1 < height) prepare(y + 1);
    differences(row(y - 1), row(y), row(y + 1), width, &gradient.dx[gradient.index(0, y)],
                &gradient.dy[gradient.index(0, y)]);
  }
  return gradient;
}

}  // namespace cpplus
