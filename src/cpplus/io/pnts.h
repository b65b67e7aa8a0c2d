#pragma once

#include <Eigen/Core>
#include <span>
#include <string>

#include "cpplus/core/image.h"

namespace cpplus {

/// Points as the bytes of a 3D Tiles 1.0 "pnts" file: a header of 28 bytes, a feature table in JSON, and for each point
/// its position as three 16-bit numbers, steps of 1/65535 of the box of all points, and its colour. Positions are in
/// metres in the frame of the tile set; the file holds them exactly to half a step. `colors` is as long as `positions`,
/// which must not be empty.
std::string encode_pnts(std::span<const Eigen::Vector3d> positions, std::span<const Rgb> colors);

}  // namespace cpplus
