#pragma once
// Raw readings -> pose. An interferometer reads the path along its beam; what the robot did along
// the axis differs from it by geometry that the tilts of the end-effector bring in. Signs and
// frames: rx, ry, rz are small rotations of the end-effector about the fixed axes x, y, z,
// right-handed; lengths grow along the positive axes. Air is corrected inside the interferometer
// adapter, from its own probe.
//
// The linear axis measures no tilt: its stage is the identity, said here so that everybody asks the
// same function.

#include <array>

#include "server/core/units.h"

namespace driftwise::correction {

using Vector3 = std::array<double, 3>;  // x, y, z

struct Tilt {  // of the end-effector; 0 where it is not measured
  double rx_arcsec = 0, ry_arcsec = 0, rz_arcsec = 0;
};

// Where the beam of one axis meets its mirror, from the centre of rotation: at_zero_mm at pose
// zero, and how it moves with the pose. A beam that is fixed in the room in front of a mirror that
// moves sideways has per_pose -1 on that side.
struct BeamOffset {
  Vector3 at_zero_mm{};
  Vector3 per_pose{};  // mm of offset per mm of pose, axis by axis
  Vector3 at(const Vector3& pose_mm) const {
    return {at_zero_mm[0] + per_pose[0] * pose_mm[0], at_zero_mm[1] + per_pose[1] * pose_mm[1],
            at_zero_mm[2] + per_pose[2] * pose_mm[2]};
  }
};

// The share of a path along a tilted mirror's normal that lies along the axis: x cos(ry) cos(rz), y
// cos(rx) cos(rz), z cos(rx) cos(ry). path_mm, result: x, y, z.
Vector3 cosine_corrected(const Vector3& path_mm, const Tilt& tilt);

// What a tilt adds to each path when the beam meets its mirror at offset_mm from the centre of
// rotation: the first order of rotation x offset, dx = ry a_z - rz a_y, dy = rz a_x - rx a_z, dz =
// rx a_y - ry a_x. Subtract it from the path. offset_mm[i]: that of axis i's own beam. The
// neglected second order is below a (tilt)^2 / 2: 0.003 nm at 0.1 mm and 50 arcsec, 0.3 nm at 10
// mm.
Vector3 abbe_error(const std::array<Vector3, 3>& offset_mm, const Tilt& tilt);

// Displacements along the axes from those along the directions in which the interferometers
// measure: direction i is axis i turned by the small rotation rotation_arcsec[i] about x, y, z. To
// first order n_i = e_i + r_i x e_i; three displacements n_i . p are solved for p by iteration,
// each step leaving the angle's share of the step before (below 1e-12 of a length at an arcminute).
Vector3 along_axes(const Vector3& measured_mm, const std::array<Vector3, 3>& rotation_arcsec);

struct Stage {
  std::array<BeamOffset, 3> beams{};  // all zero: no Abbe correction
  std::array<Vector3, 3> directions_arcsec{};
  bool cosine = false;
};

// Cosine, then directions, then Abbe with the offsets at the lengths so found: they differ from the
// pose by the Abbe error itself, which moves a lever by 1 um for each 0.3 nm at an arcminute.
Vector3 pose_from_paths(const Vector3& path_mm, const Tilt& tilt, const Stage& stage);

}  // namespace driftwise::correction
