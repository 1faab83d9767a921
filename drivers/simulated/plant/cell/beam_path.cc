#include "drivers/simulated/plant/cell/beam_path.h"

#include <cmath>

#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {

LightRay folded(const LightRay& ray, Vec3 mirror_point_mm, Vec3 mirror_normal) {
  const double distance_mm = dot(ray.from_mm - mirror_point_mm, mirror_normal);
  return {.from_mm = ray.from_mm - 2 * distance_mm * mirror_normal,
          .along = ray.along - 2 * dot(ray.along, mirror_normal) * mirror_normal};
}

PathReading path_to(const LightRay& ray, const CubeFace& face) {
  const double cosine = -dot(ray.along, face.normal);
  const double straight_mm = dot(ray.from_mm - face.middle_mm, face.normal) / cosine;
  const Vec3 spot = ray.from_mm + straight_mm * ray.along - face.middle_mm;
  const double u = dot(spot, face.first) / face.half_edge_mm;
  const double v = dot(spot, face.second) / face.half_edge_mm;
  const double figure_nm = face.figure_nm[0] * (u * u - v * v) + face.figure_nm[1] * u * v +
                           face.figure_nm[2] * (u * u + v * v);
  return {.path_mm = straight_mm * cosine * cosine - figure_nm / kNmPerMm,
          .tilt_rad = std::acos(std::min(1.0, cosine))};
}

}  // namespace driftwise::simulated
