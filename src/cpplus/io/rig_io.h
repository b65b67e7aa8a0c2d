#pragma once

#include <string>

#include "cpplus/geometry/rig.h"

namespace cpplus {

/// Reads cameras and extrinsics; the keys of the file tell its format (docs/poses.md has them with their directions):
/// our own rig.yaml, a Kalibr camchain, an R3LIVE or a FAST-LIVO2 configuration. `intrinsics` is a file with the
/// camera's model for a format that may keep it elsewhere (FAST-LIVO2); "" = none. Of several cameras one without an
/// image_prefix gets "NAME/".
///
/// Throws Error naming file, key and value.
Rig read_rig(const std::string& path, const std::string& intrinsics);

/// Reads the model of one camera: ROS camera_info YAML, FAST-LIVO2's camera file, or a Kalibr camchain of one camera.
Camera read_intrinsics(const std::string& path);

/// Writes our own format.
void write_rig(const std::string& path, const Rig& rig);

}  // namespace cpplus
