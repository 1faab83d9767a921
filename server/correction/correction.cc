#include "server/correction/correction.h"

#include <cmath>

namespace driftwise::correction {

Vector3 cosine_corrected(const Vector3& path_mm, const Tilt& tilt) {
  const double cx = std::cos(rad_from_arcsec(tilt.rx_arcsec)),
               cy = std::cos(rad_from_arcsec(tilt.ry_arcsec)),
               cz = std::cos(rad_from_arcsec(tilt.rz_arcsec));
  return {path_mm[0] * cy * cz, path_mm[1] * cx * cz, path_mm[2] * cx * cy};
}

Vector3 abbe_error(const std::array<Vector3, 3>& offset_mm, const Tilt& tilt) {
  const double rx = rad_from_arcsec(tilt.rx_arcsec), ry = rad_from_arcsec(tilt.ry_arcsec),
               rz = rad_from_arcsec(tilt.rz_arcsec);
  const auto& [x_beam, y_beam, z_beam] = offset_mm;
  return {ry * x_beam[2] - rz * x_beam[1], rz * y_beam[0] - rx * y_beam[2],
          rx * z_beam[1] - ry * z_beam[0]};
}

Vector3 along_axes(const Vector3& measured_mm, const std::array<Vector3, 3>& rotation_arcsec) {
  constexpr int kSteps = 4;
  Vector3 p = measured_mm;
  for (int step = 0; step < kSteps; ++step) {
    Vector3 next = measured_mm;
    for (std::size_t i = 0; i < 3; ++i) {
      // r x e_i has r_k on the axis after i and -r_j on the one after that, for (i, j, k) cyclic.
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      next[i] -= rad_from_arcsec(rotation_arcsec[i][k]) * p[j] -
                 rad_from_arcsec(rotation_arcsec[i][j]) * p[k];
    }
    p = next;
  }
  return p;
}

Vector3 pose_from_paths(const Vector3& path_mm, const Tilt& tilt, const Stage& stage) {
  const Vector3 along =
      along_axes(stage.cosine ? cosine_corrected(path_mm, tilt) : path_mm, stage.directions_arcsec);
  const Vector3 error = abbe_error(
      {stage.beams[0].at(along), stage.beams[1].at(along), stage.beams[2].at(along)}, tilt);
  return {along[0] - error[0], along[1] - error[1], along[2] - error[2]};
}

}  // namespace driftwise::correction
