#include "cpplus/simulate/material.h"

#include <algorithm>
#include <cmath>

#include "cpplus/simulate/hash.h"

namespace cpplus {
namespace {

using Eigen::Vector2f;
using Eigen::Vector2i;
using Eigen::Vector3f;

float cell_random(const Vector2i& cell, uint32_t seed) {
  const auto x = static_cast<uint32_t>(cell.x());
  const auto y = static_cast<uint32_t>(cell.y());
  return hash_uniform(hash_seed(seed, (static_cast<uint64_t>(x) << 32) | y));
}

Vector2i floor2(const Vector2f& x) {
  return Vector2i(static_cast<int>(std::floor(x.x())), static_cast<int>(std::floor(x.y())));
}

Vector3f mix(const Vector3f& a, const Vector3f& b, float t) { return a + t * (b - a); }

/// 1 inside a stripe of half width `half` around 0, 0 outside, blurred over the footprint.
float stripe(float distance, float half, float footprint) {
  const float soft = std::max(footprint, 1e-5f);
  return std::clamp((half - std::abs(distance)) / soft + 0.5f, 0.0f, 1.0f) * std::min(1.0f, 2.0f * half / soft + 0.2f);
}

/// Distance to the nearest border of a unit cell, in cell units.
float border_distance(const Vector2f& cell_position) {
  const Vector2f frac = cell_position - cell_position.array().floor().matrix();
  return std::min({frac.x(), frac.y(), 1.0f - frac.x(), 1.0f - frac.y()});
}

Vector3f mottled(const Material& m, const Vector2f& uv, float footprint, float scale, float strength) {
  const float stain = fractal_noise(uv / scale, 5, footprint / scale, m.seed);
  return m.color * std::max(0.05f, 1.0f + m.contrast * strength * stain);
}

Vector3f tiles(const Material& m, const Vector2f& uv, float footprint) {
  const Vector2f x = uv / m.scale_m;
  const Vector2i cell = floor2(x);
  const float tone = 1.0f + 0.22f * m.contrast * (cell_random(cell, m.seed) - 0.5f);
  const Vector3f tile = tone * mottled(m, uv + Vector2f(3.7f * cell.x(), 1.3f * cell.y()), footprint, 0.25f, 0.10f);
  return mix(tile, m.color2, stripe(border_distance(x) * m.scale_m, 0.003f, footprint));
}

Vector3f carpet(const Material& m, const Vector2f& uv, float footprint) {
  const Vector2i cell = floor2(uv / m.scale_m);
  const Vector3f base = ((cell.x() + cell.y()) & 1) ? m.color : m.color2;
  const float grain = fractal_noise(uv / 0.03f, 3, footprint / 0.03f, m.seed) * 0.25f;
  const float stain = fractal_noise(uv / 0.8f, 4, footprint / 0.8f, m.seed + 9) * 0.15f;
  return base * (1.0f + m.contrast * (grain + stain + 0.16f * (cell_random(cell, m.seed) - 0.5f)));
}

Vector3f wood(const Material& m, const Vector2f& uv, float footprint) {
  const float warp = fractal_noise(Vector2f(uv.x() / 0.7f, uv.y() / 0.12f), 3, footprint / 0.12f, m.seed);
  const float ring = std::sin(2.0f * static_cast<float>(M_PI) * (uv.y() / 0.045f + 1.4f * warp));
  const float fade = std::clamp(1.0f - footprint / 0.03f, 0.0f, 1.0f);
  const float fibre = fractal_noise(Vector2f(uv.x() / 0.12f, uv.y() / 0.008f), 2, footprint / 0.008f, m.seed + 5);
  return mix(m.color, m.color2, std::clamp(0.45f + m.contrast * (0.3f * ring * fade + 0.25f * fibre), 0.0f, 1.0f));
}

Vector3f planks(const Material& m, const Vector2f& uv, float footprint) {
  const float row = std::floor(uv.y() / m.scale_m);
  const float length = 8.0f * m.scale_m;
  const float shifted = uv.x() / length + 0.37f * row;
  const Vector2i cell(static_cast<int>(std::floor(shifted)), static_cast<int>(row));
  Material board = m;
  board.seed =
      m.seed + static_cast<uint32_t>(
                   hash_seed(m.seed, static_cast<uint32_t>(cell.x()), static_cast<uint32_t>(cell.y())) & 0xffff);
  const Vector3f base = wood(board, uv, footprint) * (1.0f + 0.35f * (cell_random(cell, m.seed) - 0.5f));
  const float to_side = uv.y() - m.scale_m * std::round(uv.y() / m.scale_m);
  const float to_end = (shifted - std::round(shifted)) * length;
  const float joint = std::max(stripe(to_side, 0.0015f, footprint), stripe(to_end, 0.0015f, footprint));
  return mix(base, 0.25f * base, joint);
}

Vector3f brick(const Material& m, const Vector2f& uv, float footprint) {
  const float height = m.scale_m;
  const float length = 3.2f * height;
  const float row = std::floor(uv.y() / height);
  const float shifted = uv.x() / length + 0.5f * (static_cast<int>(row) & 1);
  const Vector2i cell(static_cast<int>(std::floor(shifted)), static_cast<int>(row));
  const float tone = 1.0f + 0.5f * m.contrast * (cell_random(cell, m.seed) - 0.5f);
  const Vector3f base = tone * mottled(m, uv, footprint, 0.08f, 0.25f);
  const float to_bed = uv.y() - height * std::round(uv.y() / height);
  const float to_head = (shifted - std::round(shifted)) * length;
  return mix(base, m.color2, std::max(stripe(to_bed, 0.006f, footprint), stripe(to_head, 0.006f, footprint)));
}

Vector3f concrete(const Material& m, const Vector2f& uv, float footprint) {
  const Vector2f panel = uv.cwiseQuotient(Vector2f(2.4f, 1.2f));
  const Vector2f in_panel = (panel - panel.array().floor().matrix()).cwiseProduct(Vector2f(2.4f, 1.2f));
  Vector3f base = mottled(m, uv, footprint, 0.6f, 0.35f);
  base *=
      1.0f + 0.1f * m.contrast * fractal_noise(Vector2f(uv.x() / 0.1f, uv.y() / 1.2f), 2, footprint / 0.1f, m.seed + 3);
  const float to_joint = std::min({in_panel.x(), in_panel.y(), 2.4f - in_panel.x(), 1.2f - in_panel.y()});
  const Vector2f hole(std::abs(in_panel.x() - 1.2f) - 0.7f, in_panel.y() - 0.6f);
  const float mark = std::max(0.7f * stripe(to_joint, 0.004f, footprint), stripe(hole.norm(), 0.013f, footprint));
  return mix(base, m.color2, mark);
}

Vector3f asphalt(const Material& m, const Vector2f& uv, float footprint) {
  const float grain = fractal_noise(uv / 0.05f, 4, footprint / 0.05f, m.seed);
  const float patch = value_noise(uv / 2.7f, m.seed + 1) > 0.55f ? 0.72f : 1.0f;
  const float crack_line = std::abs(fractal_noise(uv / 1.7f, 4, footprint / 1.7f, m.seed + 2));
  const float crack = stripe(crack_line * 1.7f, 0.006f, footprint);
  return m.color * (patch * (1.0f + 0.35f * m.contrast * grain) * (1.0f - 0.6f * crack) *
                    (1.0f + 0.12f * fractal_noise(uv / 5.0f, 3, 0.0f, m.seed + 4)));
}

/// 1 on ink of a made-up letter of a 5 x 7 raster (symmetric about its middle column, as many capitals are).
float glyph_ink(const Vector2f& in_letter, uint64_t letter, float soft) {
  if ((in_letter.array() < 0.0f).any() || (in_letter.array() >= 1.0f).any()) return 0.0f;
  const int column = static_cast<int>(in_letter.x() * 5.0f);
  const int row = static_cast<int>(in_letter.y() * 7.0f);
  const int mirrored = std::min(column, 4 - column);
  const bool ink = (hash_seed(letter, static_cast<uint64_t>(mirrored * 7 + row)) & 7) < 5 &&
                   (column == 0 || row % 3 == 0 || column == 2);
  return ink ? std::clamp(1.2f - soft, 0.25f, 1.0f) : 0.0f;
}

/// 1 on ink of a line of letters of the given height starting at the origin.
float text_ink(const Vector2f& position, float height, int num_letters, uint32_t seed, float footprint) {
  const float advance = 0.8f * height;
  const auto index = static_cast<int>(std::floor(position.x() / advance));
  if (index < 0 || index >= num_letters || position.y() < 0.0f || position.y() > height) return 0.0f;
  const uint64_t letter = hash_seed(seed, static_cast<uint64_t>(index));
  if (letter % 7 == 0) return 0.0f;  // gap between words
  return glyph_ink(Vector2f((position.x() - advance * index) / (0.68f * height), position.y() / height), letter,
                   footprint / (0.15f * height));
}

Vector3f poster(const Material& m, const Vector2f& uv, float footprint) {
  const Vector2f size = m.size_m;
  const float rim = 0.03f * size.x();
  const Vector3f paper = Vector3f(0.85f, 0.84f, 0.80f);
  if (uv.x() < rim || uv.y() < rim || uv.x() > size.x() - rim || uv.y() > size.y() - rim) return paper;
  const float picture_low = 0.42f * size.y();
  if (uv.y() > picture_low) {
    const float a = fractal_noise(uv / (0.25f * size.x()), 4, footprint / (0.25f * size.x()), m.seed);
    const float b = fractal_noise(uv / (0.35f * size.x()), 3, footprint / (0.35f * size.x()), m.seed + 1);
    const Vector2f sun =
        uv - Vector2f(0.3f * size.x() + 0.1f * size.x() * hash_uniform(hash_seed(m.seed, 3)), 0.78f * size.y());
    const float disc = stripe(sun.norm(), 0.12f * size.x(), footprint);
    const Vector3f sky = mix(m.color, m.color2, std::clamp(0.5f + a, 0.0f, 1.0f));
    const float hill = uv.y() - picture_low - 0.2f * size.y() -
                       0.1f * size.y() * value_noise(Vector2f(uv.x() / (0.2f * size.x()), 0.5f), m.seed + 2);
    const Vector3f land = (0.35f + 0.3f * b) * Vector3f(m.color2.z(), m.color2.x(), m.color2.y());
    return mix(mix(sky, Vector3f(0.9f, 0.75f, 0.2f), disc), land,
               std::clamp(-hill / std::max(footprint, 1e-4f) + 0.5f, 0.0f, 1.0f));
  }
  float ink = text_ink(uv - Vector2f(0.08f * size.x(), 0.31f * size.y()), 0.075f * size.y(), 14, m.seed + 7, footprint);
  const float line_pitch = 0.036f * size.y();
  const auto line = static_cast<int>(std::floor((uv.y() - 0.06f * size.y()) / line_pitch));
  if (line >= 0 && line < 6) {
    ink = std::max(ink,
                   text_ink(uv - Vector2f(0.08f * size.x(), 0.06f * size.y() + line_pitch * static_cast<float>(line)),
                            0.02f * size.y(), 40 + line % 3 * 4, m.seed + 11 + static_cast<uint32_t>(line), footprint));
  }
  return mix(paper, Vector3f(0.06f, 0.06f, 0.12f), ink);
}

Vector3f sign(const Material& m, const Vector2f& uv, float footprint) {
  const float height = 0.6f * m.size_m.y();
  const auto letters = static_cast<int>(0.85f * m.size_m.x() / (0.8f * height));
  const Vector2f start(0.5f * (m.size_m.x() - 0.8f * height * static_cast<float>(letters)), 0.2f * m.size_m.y());
  return mix(m.color, m.color2, text_ink(uv - start, height, letters, m.seed, footprint));
}

Vector3f checkerboard(const Material& m, const Vector2f& uv) {
  const Vector2f x = uv / m.scale_m - Vector2f::Constant(0.5f);
  const Vector2i cell = floor2(x);
  const bool rim = (cell.array() < 0).any() || (cell.array() >= m.cells.array()).any();
  return !rim && ((cell.x() + cell.y()) & 1) == 0 ? m.color2 : m.color;
}

Vector3f rug(const Material& m, const Vector2f& uv, float footprint) {
  const float border = std::min({uv.x(), uv.y(), m.size_m.x() - uv.x(), m.size_m.y() - uv.y()});
  const Vector3f third(m.color2.y(), m.color2.z(), m.color2.x());
  Vector3f base = m.color;
  if (border < 0.22f) {
    const int band = static_cast<int>(border / 0.04f);
    base = band % 3 == 1 ? m.color2 : (band % 3 == 2 ? third : m.color);
  } else {
    const Vector2f x((uv.x() + uv.y()) / 0.3f, (uv.x() - uv.y()) / 0.3f);
    const float pick = cell_random(floor2(x), m.seed);
    if (border_distance(x) > 0.15f) base = pick < 0.35f ? m.color : (pick < 0.7f ? m.color2 : third);
  }
  return base * (1.0f + 0.2f * fractal_noise(uv / 0.02f, 2, footprint / 0.02f, m.seed));
}

Vector3f cardboard(const Material& m, const Vector2f& uv, float footprint) {
  const float flute = std::sin(uv.x() / 0.004f) * std::clamp(1.0f - footprint / 0.008f, 0.0f, 1.0f);
  Vector3f base = mottled(m, uv, footprint, 0.2f, 0.2f) * (1.0f + 0.05f * flute);
  const float tape = stripe(uv.y() - 0.16f, 0.025f, footprint);
  base = mix(base, 1.35f * m.color, 0.7f * tape);
  return mix(base, 0.2f * m.color, text_ink(uv - Vector2f(0.05f, 0.05f), 0.04f, 9, m.seed, footprint));
}

Vector3f ceiling_panel(const Material& m, const Vector2f& uv, float footprint) {
  const Vector2f x = uv / m.scale_m;
  const float joint = stripe(border_distance(x) * m.scale_m, 0.004f, footprint);
  const float speck = fractal_noise(uv / 0.025f, 2, footprint / 0.025f, m.seed);
  return mix(m.color * (1.0f - 0.15f * std::max(0.0f, speck) + 0.04f * (cell_random(floor2(x), m.seed) - 0.5f)),
             m.color2, joint);
}

Vector3f door(const Material& m, const Vector2f& uv, float footprint) {
  Vector3f base = wood(m, uv, footprint);
  for (const float low : {0.15f, 1.1f}) {
    const Vector2f half(0.3f, 0.38f);
    const Vector2f d = (uv - Vector2f(0.45f, low + 0.38f)).cwiseAbs() - half;
    const float to_frame = std::max(d.x(), d.y());
    base = mix(base, (uv.y() > low + 0.38f ? 0.5f : 1.3f) * base, stripe(to_frame, 0.008f, footprint));
  }
  return base;
}

}  // namespace

float value_noise(const Vector2f& x, uint32_t seed) {
  const Vector2i cell = floor2(x);
  Vector2f t = x - cell.cast<float>();
  t = t.array() * t.array() * (3.0f - 2.0f * t.array());
  const float a = cell_random(cell, seed);
  const float b = cell_random(cell + Vector2i(1, 0), seed);
  const float c = cell_random(cell + Vector2i(0, 1), seed);
  const float d = cell_random(cell + Vector2i(1, 1), seed);
  return 2.0f * ((a + (b - a) * t.x()) * (1.0f - t.y()) + (c + (d - c) * t.x()) * t.y()) - 1.0f;
}

float fractal_noise(const Vector2f& x, int octaves, float footprint, uint32_t seed) {
  float sum = 0.0f;
  float weight = 0.5f;
  float frequency = 1.0f;
  for (int i = 0; i < octaves; ++i) {
    const float fade = std::clamp(1.5f - 2.0f * footprint * frequency, 0.0f, 1.0f);
    if (fade <= 0.0f) break;
    sum += fade * weight *
           value_noise(x * frequency + Vector2f::Constant(17.0f * static_cast<float>(i)),
                       seed + static_cast<uint32_t>(i) * 101u);
    weight *= 0.5f;
    frequency *= 2.03f;
  }
  return sum;
}

Vector3f albedo(const Material& m, const Vector2f& uv, float footprint) {
  Vector3f color = m.color;
  switch (m.pattern) {
    case Pattern::kPlain:
      color = mottled(m, uv, footprint, 0.15f, 0.08f);
      break;
    case Pattern::kPlaster:
      color = mottled(m, uv, footprint, 0.5f, 0.18f);
      break;
    case Pattern::kConcrete:
      color = concrete(m, uv, footprint);
      break;
    case Pattern::kTiles:
      color = tiles(m, uv, footprint);
      break;
    case Pattern::kCarpet:
      color = carpet(m, uv, footprint);
      break;
    case Pattern::kWood:
      color = wood(m, uv, footprint);
      break;
    case Pattern::kPlanks:
      color = planks(m, uv, footprint);
      break;
    case Pattern::kBrick:
      color = brick(m, uv, footprint);
      break;
    case Pattern::kAsphalt:
      color = asphalt(m, uv, footprint);
      break;
    case Pattern::kPoster:
      color = poster(m, uv, footprint);
      break;
    case Pattern::kSign:
      color = sign(m, uv, footprint);
      break;
    case Pattern::kCheckerboard:
      color = checkerboard(m, uv);
      break;
    case Pattern::kRug:
      color = rug(m, uv, footprint);
      break;
    case Pattern::kCardboard:
      color = cardboard(m, uv, footprint);
      break;
    case Pattern::kCeilingPanel:
      color = ceiling_panel(m, uv, footprint);
      break;
    case Pattern::kDoor:
      color = door(m, uv, footprint);
      break;
  }
  return color.cwiseMax(0.01f).cwiseMin(0.95f);
}

}  // namespace cpplus
