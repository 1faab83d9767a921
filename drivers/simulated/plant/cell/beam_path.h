#pragma once
// What a plane-mirror interferometer counts: a beam, perhaps turned by a mirror on its way, against
// a face of the cube.

#include <array>

#include "drivers/simulated/plant/numbers/vector3.h"

namespace driftwise::simulated {

struct LightRay {
  Vec3 from_mm;
  Vec3 along;  // unit
};

// Seen through a plane mirror: the ray as if it came straight.
LightRay folded(const LightRay& ray, Vec3 mirror_point_mm, Vec3 mirror_normal);

struct CubeFace {
  Vec3 middle_mm;
  Vec3 normal;         // unit, outward
  Vec3 first, second;  // unit, in the face
  double half_edge_mm = 0;
  std::array<double, 3> figure_nm{};  // outward: u^2 - v^2, u v, u^2 + v^2 over half_edge^2
};

struct PathReading {
  double path_mm = 0;
  double tilt_rad = 0;  // of the face against the beam
};
// The way to the face times cos^2 of the tilt: the returning wave front is tilted by twice the
// angle, and its phase where the beam left is that of a mirror at the foot of the perpendicular.
PathReading path_to(const LightRay& ray, const CubeFace& face);

}  // namespace driftwise::simulated
