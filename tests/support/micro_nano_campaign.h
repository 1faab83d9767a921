#pragma once
// The published measuring plan of case B, run directly on the simulated Micro-Nano: no wire, no
// daemon. What the mathematics is tested with.
//
// Five grids in motor coordinates (thesis 6.2.2): calibration 6x6x6 over 0 .. 2.5 mm with a return
// to zero after every line of six (252 points), validation 5x5x5 over 0.25 .. 2.25 mm with a return
// after every line of five (150); forces in the published order 0, 2.305, 0.768, 1.536, 3.842 N,
// the calibration grid under the first, second and fourth. 1056 points in 5.5 h. Nothing is
// corrected here: lengths are as the interferometers give them, angles as the autocollimators do,
// both relative to the zero pose that was taken before the first point.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/simulated/plant/micro_nano_plant.h"

namespace driftwise::testing_support {

struct MicroNanoRow {
  double time_s = 0;                    // middle of the readings, since the epoch
  std::array<double, 3> q_mm{};         // read back, mean over the readings
  std::array<double, 3> q_cmd_mm{};     //
  std::array<double, 3> path_mm{};      // x, y, z as the interferometers show them: not corrected
  std::array<double, 3> path_std_nm{};  // sample standard deviation of the readings
  std::array<double, 3> r_arcsec{};     // rx, ry, rz as the autocollimators show them since the zero
  std::array<double, 10> t_degc{};      // t01 .. t10 by each probe's certificate
  std::array<double, 3> air_degc{};     // of each interferometer's own probe
  double force_n = 0;                   // as declared: nominal mass x 9.81, what the cell knows
  int grid = 0;                         // 0 .. 4, in the order above; further grids go on counting
  int line = 0;                         // of the grid; a return to zero belongs to the line before
  bool calibration = false;
  bool zero = false;  // a return to zero
  // The truth at the same instants, since the zero pose: where the cube's centre is and how it is
  // turned, in the robot's frame; what really pulls.
  std::array<double, 3> true_mm{};
  std::array<double, 3> true_r_arcsec{};
  std::array<double, 3> true_q_mm{};  // the scales without quantisation and jitter
  double true_force_n = 0;
};

struct MicroNanoGrid {
  bool calibration = true;  // 6x6x6 or 5x5x5
  double force_n = 0;
};

struct MicroNanoOptions {
  std::uint64_t seed = 1;
  std::vector<std::string> overrides;  // "section.key=value" over the plant file
  std::vector<MicroNanoGrid> grids{
      {true, 0}, {true, 2.305}, {false, 0.768}, {true, 1.536}, {false, 3.842}};
  // Poses in motor coordinates visited after the grids (online targets and the like), force 40 g.
  std::vector<std::array<double, 3>> further_q_mm;
  double further_force_n = 0.3924;
  double point_s = 18.75;  // 1056 in 5.5 h
  int readings = 4;
  int samples = 8192;  // per reading: 2 s
  // Coarse: thermal steps of 2 s instead of 0.1 s and one instant per reading; the same physics and
  // spreads, other random numbers. For many campaigns.
  bool coarse = false;
};

std::filesystem::path micro_nano_plant_file(const std::string& source_dir);

// A whole campaign on a new plant. Throws PlantFileError when the file or an override is wrong.
std::vector<MicroNanoRow> run_micro_nano_campaign(const std::filesystem::path& plant_file,
                                                  const MicroNanoOptions& options = {});

// The same on a plant that is there: the caller can go on with it afterwards. Starts at start_s
// since the epoch; end_s receives when the last point was over.
std::vector<MicroNanoRow> run_micro_nano_campaign(simulated::MicroNanoPlant& plant,
                                                  simulated::TimeNs epoch,
                                                  const MicroNanoOptions& options);

// One more pose on a plant that has run a campaign: moves, settles and reads from now on. The row
// is relative to the campaign's zero.
class MicroNanoVisitor {
 public:
  MicroNanoVisitor(simulated::MicroNanoPlant& plant, simulated::TimeNs epoch,
                   const MicroNanoOptions& options);
  void load(double force_n);
  MicroNanoRow visit(const std::array<double, 3>& q_mm);
  double now_s() const { return now_s_; }

 private:
  void zero();
  MicroNanoRow read(double start_s);
  simulated::MicroNanoPlant& plant_;
  simulated::TimeNs epoch_;
  MicroNanoOptions options_;
  double now_s_ = 0, force_n_ = 0;
  std::array<double, 3> zero_r_arcsec_{}, true_zero_mm_{}, true_zero_r_arcsec_{};
};

}  // namespace driftwise::testing_support
