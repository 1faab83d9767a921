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

Vector3 pose_from_paths(const Vector3& path_mm, const Tilt& tilt, const Stage& stage) {
  const Vector3 along = stage.cosine ? cosine_corrected(path_mm, tilt) : path_mm;
  const Vector3 error = abbe_error(
      {stage.beams[0].at(along), stage.beams[1].at(along), stage.beams[2].at(along)}, tilt);
  return {along[0] - error[0], along[1] - error[1], along[2] - error[2]};
}

}  // namespace driftwise::correction
