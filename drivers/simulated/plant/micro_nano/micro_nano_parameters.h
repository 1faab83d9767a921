#pragma once
// What the plant file of the Micro-Nano says beyond the cell's. Names, units and sources:
// deploy/cells/micro-nano/plant.toml.

#include <array>
#include <string>
#include <vector>

#include "drivers/simulated/plant/micro_nano/flexure_hinge.h"
#include "drivers/simulated/plant/numbers/vector3.h"
#include "drivers/simulated/plant/plant_parameters.h"

namespace driftwise::simulated {

inline constexpr std::size_t kArms = 3;
template <class T>
using PerArm = std::array<T, kArms>;

// A length that follows the temperature of a part.
struct WarmLength {
  double mm = 0;
  double expansion_per_k = 0;
  std::vector<int> parts{};  // plain mean
};

struct DeltaParameters {
  PerArm<double> azimuth_deg{};
  double column_radius_mm = 0;    // robot's axis to the carriage's joints
  double platform_radius_mm = 0;  // to the platform's joints
  double arm_mm = 0;
  double pair_spacing_mm = 0;
  // What carries a carriage's joints, as lengths that warm up: outwards along the base, inwards
  // through the guide; upwards through the column, guide and stage.
  PerArm<std::vector<WarmLength>> outwards{}, upwards{};
  PerArm<int> arm_part{};
  double arm_expansion_per_k = 0;
  int platform_part = 0;
  double platform_expansion_per_k = 0;
  // Guide: a parallelogram of two legs that lie tangentially.
  double leg_mm = 0, leg_spacing_mm = 0, shortening_factor = 0, neutral_mm = 0;
  double scale_expansion_per_k = 0;
  PerArm<int> scale_part{};
  FlexureHinge hinge;  // of the bars: one pair of crossed blades at each end
  int hinges_per_bar = 0;
  double bar_section_mm2 = 0;
  double moving_kg = 0;  // platform, cube and half of the bars
};

// Standard deviations of what a workshop leaves; one draw per machine.
struct ToleranceParameters {
  double column_mm = 0;   // place of a guide, each direction
  double guide_mrad = 0;  // its axis against the vertical
  double mount_mrad = 0;  // a pair's joint line and plane on the carriage
  double skew_mrad = 0;   // hinge axes of a guide against one another
  double joint_mm = 0;    // each joint, each direction
  double bar_mm = 0;      // each bar's length
  double leg_mm = 0;      // a guide's legs
  double scale_ppm = 0;   // division error of a scale
};

struct CubeParameters {
  Vec3 centre_mm;  // from the middle of the platform's joints
  double edge_mm = 0;
  double flatness_nm = 0;   // of a face, peak to valley
  double facet_arcsec = 0;  // of a face's normal, standard deviation
};

struct BeamParameters {
  double offset_u_mm = 0;  // spot on the face from the cube's centre at the zero pose, as known
  double offset_v_mm = 0;  // (u, v) = (y, z) for x, (x, z) for y, (x, y) for z
  double sign = 1;         // + along the robot's axis
  std::vector<WarmLength> datum{};   // robot: from its middle to the face the beam is tied to
  std::vector<WarmLength> device{};  // support, bridge and head
};

struct OpticsParameters {
  double offset_mm = 0;          // half width of what is not known of a spot's place
  double alignment_arcsec = 0;   // of a beam to its mirror, standard deviation
  double tilt_limit_arcsec = 0;  // beyond it the light does not come back
  double fold_height_mm = 0;     // of the 45 degree mirror above the cube's upper face
  double fold_span_mm = 0;       // between the columns that carry it
};

struct CollimatorParameters {
  double range_arcsec = 0, noise_arcsec = 0, noise_s = 0, drift_arcsec = 0, drift_s = 0;
  double alignment_arcsec = 0;  // zero offset, standard deviation
  double roll_mrad = 0;         // about the beam
  double scale_error = 0;       // relative, standard deviation
  // The 45 degree mirror over which the first one sees ry turns by so much per kelvin of a part,
  // and the robot does not. 0: it looks straight.
  double mirror_arcsec_per_k = 0;
  int mirror_part = 0;
};

struct LoadParameters {
  double max_n = 0, weight_n = 0;  // all weights, one of them
  double seconds_per_weight = 0, swing_share = 0, swing_s = 0, swing_period_s = 0, rest_s = 0;
  double g_declared_m_s2 = 0, g_here_m_s2 = 0;
  double pan_n = 0;
  double friction = 0;          // of both pulleys, share of the tension
  double wire_n_mm = 0;         // stiffness of the wire
  Vec3 attach_mm;               // on the platform, from the middle of its joints
  double pulley_height_mm = 0;  // above that point at mid-stroke
};

struct MicroNanoParameters : CellParameters {
  std::uint64_t machine = 0;  // 0: drawn with the plant's seed; else this machine
  DeltaParameters delta;
  ToleranceParameters tolerance;
  CubeParameters cube;
  PerArm<BeamParameters> beams{};
  OpticsParameters optics;
  CollimatorParameters collimator;
  LoadParameters load;
};

}  // namespace driftwise::simulated
