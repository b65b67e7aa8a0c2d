#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace cpplus {

/// What a surface looks like. Patterns are procedural functions of the face's own (u, v), in metres.
enum class Pattern : uint8_t {
  kPlain,         // slight mottling only
  kPlaster,       // wall paint: stains and fine grain
  kConcrete,      // stains, panel joints, tie holes
  kTiles,         // square tiles with joints, each a little different
  kCarpet,        // carpet squares in alternating tones
  kWood,          // grain along u
  kPlanks,        // boards along u with staggered joints
  kBrick,         // running bond
  kAsphalt,       // grain, patches, cracks
  kPoster,        // picture above lines of text, over the whole face (size_m)
  kSign,          // one row of big letters over the whole face (size_m)
  kCheckerboard,  // cells() squares of scale_m with a white rim of one half square
  kRug,           // border stripes and diamonds over the whole face (size_m)
  kCardboard,     // corrugated board with tape and print
  kCeilingPanel,  // square panels with thin joints
  kDoor,          // two sunken panels drawn by shade
};

struct Material {
  Pattern pattern = Pattern::kPlain;
  Eigen::Vector3f color = Eigen::Vector3f::Constant(0.6f);   // linear albedo, 0..1
  Eigen::Vector3f color2 = Eigen::Vector3f::Constant(0.4f);  // joints, stripes, second tone
  float scale_m = 0.3f;                                      // tile, plank or square size
  float contrast = 1.0f;                                     // strength of stains and grain
  float lidar_reflectance = 1.0f;                            // factor on the albedo at the LiDAR's wavelength
  float emission = 0.0f;                                     // radiance of lamps; 0 = not a lamp
  Eigen::Vector2f size_m = Eigen::Vector2f::Ones();          // extent of patterns that fill a face
  Eigen::Vector2i cells = Eigen::Vector2i(9, 6);             // squares of a checkerboard
  uint32_t seed = 0;
};

/// Linear albedo at (u, v), metres. Detail finer than `footprint_m` (the size of a pixel on the surface) is left out,
/// which keeps far textures from turning into noise.
Eigen::Vector3f albedo(const Material& material, const Eigen::Vector2f& uv, float footprint_m);

/// Smooth noise in [-1, 1] with features of about one unit.
float value_noise(const Eigen::Vector2f& x, uint32_t seed);
/// Sum of octaves of value_noise, each half the size and weight of the one before; octaves finer than the footprint
/// (in the same unit as x) fade out.
float fractal_noise(const Eigen::Vector2f& x, int octaves, float footprint, uint32_t seed);

}  // namespace cpplus
