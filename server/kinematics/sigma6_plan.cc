#include "server/kinematics/sigma6_plan.h"

#include <cmath>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::kinematics {
namespace {

constexpr double kArcsecPerDegree = 3600;

// 33 = 27 + 6: a cube of three by three by three and a centre further out on each half axis.
std::vector<Eigen::Vector3d> centres_mm() {
  std::vector<Eigen::Vector3d> centres;
  for (int k = 0; k < 27; ++k)
    centres.emplace_back(1.5 * (k % 3 - 1), 1.5 * (k / 3 % 3 - 1), 1.5 * (k / 9 - 1));
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    for (const double side : {-2.0, 2.0}) centres.emplace_back(side * Eigen::Vector3d::Unit(axis));
  return centres;
}

// Rotation vectors: count by count by count within +-range about an offset of one axis.
std::vector<Eigen::Vector3d> turns_rad(int count, double range_arcsec, Eigen::Index axis,
                                       double offset_arcsec) {
  std::vector<Eigen::Vector3d> turns;
  const auto at = [&](int k) { return range_arcsec * (2.0 * k / (count - 1) - 1); };
  for (int k = 0; k < count * count * count; ++k) {
    Eigen::Vector3d turn(at(k % count), at(k / count % count), at(k / count / count));
    turn[axis] += offset_arcsec;
    turns.push_back(turn * kRadPerArcsec);
  }
  return turns;
}

Result<void> add_points(const SixStruts& robot, const std::vector<Eigen::Vector3d>& centres,
                        const std::vector<Eigen::Vector3d>& turns, Trajectory& plan) {
  if (plan.coordinates.empty())
    for (std::size_t i = 0; i < kStruts; ++i)
      plan.coordinates.push_back({"q" + std::to_string(i + 1), "mm"});
  for (const auto& centre : centres)
    for (const auto& turn : turns) {
      DRIFTWISE_TRY(const auto q, robot.motors({centre, turn}));
      TrajectoryPoint point;
      point.target.assign(q.begin(), q.end());
      point.line = static_cast<std::int64_t>(plan.points.size() / turns.size());
      plan.points.push_back(std::move(point));
    }
  return {};
}

std::vector<Eigen::Vector3d> cube_mm(int count, double half_mm) {
  std::vector<Eigen::Vector3d> cube;
  const auto at = [&](int k) { return half_mm * (2.0 * k / (count - 1) - 1); };
  for (int k = 0; k < count * count * count; ++k)
    cube.emplace_back(at(k % count), at(k / count % count), at(k / count / count));
  return cube;
}

}  // namespace

MirrorPrism sigma6_prism() {
  return {{-3 * kArcsecPerDegree, -1.5 * kArcsecPerDegree, 0, 1.5 * kArcsecPerDegree,
           3 * kArcsecPerDegree},
          400};
}

Result<FacetReading> facet_for(const MirrorPrism& prism, double angle_arcsec) {
  FacetReading best;
  for (std::size_t facet = 0; facet < prism.facets_arcsec.size(); ++facet) {
    const double reading = angle_arcsec - prism.facets_arcsec[facet];
    if (facet == 0 || std::abs(reading) < std::abs(best.reading_arcsec)) best = {facet, reading};
  }
  if (prism.facets_arcsec.empty() || !(std::abs(best.reading_arcsec) <= prism.range_arcsec)) {
    const double nearest = prism.facets_arcsec.empty()
                               ? 0
                               : prism.facets_arcsec[best.facet] +
                                     std::copysign(prism.range_arcsec, best.reading_arcsec);
    return fail(ErrorCode::out_of_range, reasons::kNoPose,
                "no facet of the prism reads a rotation of " + digits_text(angle_arcsec) +
                    " arcsec; the nearest that is read is " + digits_text(nearest));
  }
  return best;
}

Result<std::vector<SigmaStage>> sigma6_stages(const SixStruts& robot) {
  constexpr double kRange_arcsec = 400;
  const std::string places = "which 33 places: 3 x 3 x 3 and six further out";
  const auto centres = centres_mm();
  std::vector<SigmaStage> stages;
  SigmaStage cube{"rotations on the cube", 1, 0.5, 9, 56.5, {}, places};
  DRIFTWISE_RETURN_IF_ERROR(
      add_points(robot, centres, turns_rad(7, kRange_arcsec, 0, 0), cube.plan));
  stages.push_back(std::move(cube));
  const auto prism = sigma6_prism();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    SigmaStage stage{
        std::string("rotations by the prism about ") + "xyz" [axis], 1, 0.5, 9, 24.5, {}, places};
    for (const double facet : prism.facets_arcsec)
      if (facet != 0)
        DRIFTWISE_RETURN_IF_ERROR(
            add_points(robot, centres, turns_rad(3, kRange_arcsec, axis, facet), stage.plan));
    stages.push_back(std::move(stage));
  }
  SigmaStage moves{"pure translations, x, y, z one after the other",
                   3,
                   0.5,
                   9,
                   37.5,
                   {},
                   "the stroke of 9 x 9 x 9: +-2 mm"};
  DRIFTWISE_RETURN_IF_ERROR(
      add_points(robot, cube_mm(9, 2), {Eigen::Vector3d::Zero()}, moves.plan));
  stages.push_back(std::move(moves));
  SigmaStage full{"six degrees of freedom about the sphere, by centre",
                  33,
                  0.5,
                  9,
                  462,
                  {},
                  "rotations of one centre: those of the cube and of the prisms; the loop that is "
                  "closed on the parasitic translation takes the rest of its 4.5 h"};
  const std::vector<Eigen::Vector3d> centre{Eigen::Vector3d::Zero()};
  DRIFTWISE_RETURN_IF_ERROR(
      add_points(robot, centre, turns_rad(7, kRange_arcsec, 0, 0), full.plan));
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    for (const double facet : prism.facets_arcsec)
      if (facet != 0)
        DRIFTWISE_RETURN_IF_ERROR(
            add_points(robot, centre, turns_rad(3, kRange_arcsec, axis, facet), full.plan));
  stages.push_back(std::move(full));
  return stages;
}

}  // namespace driftwise::kinematics
