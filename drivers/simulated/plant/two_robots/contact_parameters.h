#pragma once
// Parameters of the two robots' plant file beside the robots' own files. Sources of the figures:
// deploy/cells/two-robots/plant.toml and docs/plants/two-robots.md.

#include "drivers/simulated/plant/micro_nano/micro_nano_parameters.h"
#include "drivers/simulated/plant/min_angle/min_angle_parameters.h"

namespace driftwise::simulated {

struct ContactParameters {
  double gap_mm = 0;     // tip above the substrate: upper robot at tip_at_mm, lower at 0, 20 degC
  double tip_at_mm = 0;  // height of the upper robot at which the tool was mounted
  double gap_spread_mm = 0;    // drawn, +-
  double parallelism_deg = 0;  // of the substrate on the lower robot: both tilts drawn within +-
  double lever_mm = 0;         // tip below the upper robot's cube
  double lever_spread_mm = 0;  // drawn, +-: the part from the cube to its fixation is not measured
  double hardness_gpa = 0;     // force over projected area of the indent
  double tip_radius_nm = 0;    // rounding of the pyramid's edge
  double recovery = 0;         // elastic part of the depth, when the force goes
};

struct HoldingParameters {
  double flexure_n_mm = 0;      // all axes together: what resists within the dead zone
  double dead_zone_nm = 0;      // of the servo's proportional part
  double servo_n_mm = 0;        // beyond it
  double integral_n_mm_s = 0;   // push-back: newton per mm of error and second
  double integral_zone_nm = 0;  // below it the integrator rests
  double integral_limit_n = 0;
};

struct KnockParameters {
  double hz = 0, decay_s = 0;  // of the table
};

struct MicroscopeParameters {
  double scale_x_ppm = 0, scale_y_ppm = 0;        // of its picture; hidden
  double fine_pixel_nm = 0, fine_marking_px = 0;  // within fine_um of the origin
  double fine_um = 0;
  double coarse_pixel_nm = 0, coarse_marking_px = 0;
  double picture_um = 0;  // width of a coarse picture: beyond it pictures are joined
};

struct TwoRobotsParameters {
  MicroNanoParameters upper;
  MinAngleParameters lower;
  ContactParameters contact;
  HoldingParameters holding;
  KnockParameters knock;
  MicroscopeParameters microscope;
};

}  // namespace driftwise::simulated
