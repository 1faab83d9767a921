#pragma once
// The published measuring plan, run directly on a plant: no wire, no daemon. What the mathematics
// is tested with.
//
// 56 passes over 0, -4, -3.5, .. 4 mm, 14.3 s per point, four readings of 2048 samples each, a
// group with a standard deviation above 5 nm is read again without moving (thesis
// sections 5.2.1, 5.2.2; published_results.md, case A).

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/simulated/plant/linear_axis/linear_axis_plant.h"

namespace driftwise::testing_support {

struct CampaignRow {
  double time_s = 0;                // middle of the four readings, since the epoch
  double q1_mm = 0, q1_cmd_mm = 0;  // mean of one readback per reading
  double x_mm = 0, x_std_nm = 0;    // mean and sample standard deviation of the four
  std::array<double, 10> t_degc{};  // by each probe's certificate
  bool calibration = false;         // integer millimetres
  // The truth at the same instants, nm (drivers/simulated/plant/truth.h).
  double end_effector_nm = 0, geometry_nm = 0, robot_drift_nm = 0, device_drift_nm = 0,
         air_error_nm = 0;
};

struct CampaignOptions {
  int passes = 56;
  double point_s = 14.3;
  double gate_nm = 5;
  int samples = 2048;
};

struct Campaign {
  std::vector<CampaignRow> rows;
  std::vector<double> group_std_nm;  // of every group, also of those read again
  int rejected_groups = 0;
  double zero_s = 0;                // of the interferometer, since the epoch
  double zero_end_effector_nm = 0;  // the truth then
};

Campaign run_plant_campaign(simulated::LinearAxisPlant& plant, simulated::TimeNs epoch,
                            const CampaignOptions& options = {});

// The repository's plant file (DRIFTWISE_SOURCE_DIR is the test's).
inline std::string linear_axis_plant_file(const std::string& source_dir) {
  return source_dir + "/deploy/cells/linear-axis/plant.toml";
}

// Temperature of a pt1000 above 0 degC: R = R0 (1 + A t + B t^2) solved for t (IEC 60751).
double degc_from_ohm(double ohm, double r0_ohm, double a_per_k, double b_per_k2);

}  // namespace driftwise::testing_support
