#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "cpplus/simulate/tracer.h"

namespace cpplus {

/// Radiance of the sky in a direction (unit, map frame), clouds included.
Eigen::Vector3f sky_radiance(const Sky& sky, const Eigen::Vector3f& direction);

/// What is known of the soft light on the faces of a mesh: a grid of cells a face, unknown at first. Faces that no
/// image asks for take no memory for cells.
class LightCells {
 public:
  struct FaceGrid {
    size_t first = 0;  // number of its cell (0, 0) among all cells
    int columns = 0;
    int rows = 0;
    Eigen::Vector2f low = Eigen::Vector2f::Zero();   // uv of cell (0, 0)
    Eigen::Vector2f step = Eigen::Vector2f::Ones();  // metres
  };

  LightCells(const Mesh& mesh, float cell_m);
  ~LightCells();
  LightCells(const LightCells&) = delete;
  LightCells& operator=(const LightCells&) = delete;

  const FaceGrid& grid(uint32_t face_index) const { return grids_[face_index]; }
  /// The words of a face's cells, row by row. Three 21-bit colours and a "known" bit in one word: two threads may both
  /// compute a cell, and write the same.
  std::atomic<uint64_t>* cells(uint32_t face_index) const;

 private:
  std::vector<FaceGrid> grids_;
  std::unique_ptr<std::atomic<std::atomic<uint64_t>*>[]> cells_;  // null until asked for
};

/// Light that changes slowly along a surface: lamps with soft shadows, sky and ambient light with occlusion and one
/// tinted bounce. Computed once per cell of a surface, when an image first needs it, so that its cost is shared by
/// all images; a cell's value depends on the cell alone, never on the thread or the order.
class SoftLight {
 public:
  using Parts = std::vector<std::shared_ptr<const LightCells>>;

  /// The tracer must outlive it.
  SoftLight(const Tracer& tracer, float cell_m);

  /// To be called with the cells of the tracer's parts whenever it takes others; what the cells know is kept.
  void set_parts(Parts parts) { parts_ = std::move(parts); }

  /// Irradiance / pi at a point of a surface (what a white diffuse surface there sends out), without the sun.
  Eigen::Vector3f at(const TraceHit& hit) const;

 private:
  Eigen::Vector3f cell_value(const TraceHit& hit, int column, int row) const;
  Eigen::Vector3f gather(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, uint64_t seed) const;

  const Tracer& tracer_;
  Parts parts_;
};

}  // namespace cpplus
