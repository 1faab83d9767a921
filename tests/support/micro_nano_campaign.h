#pragma once
// The published measuring plan of case B, run directly on the simulated Micro-Nano: no wire, no
// daemon. What the mathematics is tested with.
//
// Five grids in motor coordinates (thesis 6.2.2): calibration 6x6x6 over 0 .. 2.5 mm with a return
// to zero after every line of six (252 points), validation 5x5x5 over 0.25 .. 2.25 mm with a return
// after every line of five (150); forces in the published order 0, 2.305, 0.768, 1.536, 3.842 N,
// the calibration grid under the first, second and fourth. 1056 points in 5.5 h. Nothing is
// corrected here: lengths are as the interferometers give them, angles as the autocollimators do,
// both since the zero pose that was taken before the first point.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/simulated/plant/micro_nano/micro_nano_plant.h"

namespace driftwise::testing_support {

struct MicroNanoRow {
  double time_s = 0;             // middle of the readings, since the epoch
  double dwell_s = 0;            // from the end of the move to there
  std::array<double, 3> q_mm{};  // read back, mean over the readings
  std::array<double, 3> q_cmd_mm{};
  std::array<double, 3> path_mm{};      // x, y, z as the interferometers show them: not corrected
  std::array<double, 3> path_std_nm{};  // sample standard deviation of the readings; 0 for one
  std::array<double, 3> r_arcsec{};  // rx, ry, rz as the autocollimators show them since the zero
  std::array<double, 10> t_degc{};   // t01 .. t10 by each probe's certificate
  std::array<double, 3> air_degc{};  // of each interferometer's own probe
  double force_n = 0;                // as declared: nominal mass x 9.81, what the cell knows
  int grid = 0;                      // 0 .. 4 in the order above
  int line = 0;                      // of the grid; a return to zero belongs to the line before
  bool calibration = false;
  bool zero = false;  // a return to zero
  // The truth at the same instants, since the zero pose: where the cube's centre is and how it is
  // turned, in the robot's frame; what really pulls.
  std::array<double, 3> true_mm{};
  std::array<double, 3> true_r_arcsec{};
  std::array<double, 3> true_q_mm{};  // the scales without quantisation and jitter
  double true_force_n = 0;
  std::vector<double> true_part_degc{};  // of the plant's parts, in the order of its file
};

struct MicroNanoGrid {
  bool calibration = true;  // 6x6x6, else 5x5x5
  double force_n = 0;
};

struct MicroNanoOptions {
  std::uint64_t seed = 1;
  std::vector<std::string> overrides{};  // "section.key=value" over the plant file
  std::vector<MicroNanoGrid> grids{
      {true, 0}, {true, 2.305}, {false, 0.768}, {true, 1.536}, {false, 3.842}};
  double point_s = 18.75;  // 1056 in 5.5 h
  int readings = 4;
  int samples = 8192;  // per reading: 2 s
  // Coarse: steps of 2 s instead of 0.1 s, one instant per reading, one reading of all samples: the
  // same physics and spreads, other random numbers. For many campaigns.
  bool coarse = false;
};

// The robot at work after (or without) the grids: one pose at a time.
class MicroNanoSession {
 public:
  // A new plant on the repository's file (source_dir: DRIFTWISE_SOURCE_DIR); referenced, lengths
  // and angles zeroed at q = 0 without weights. Throws PlantFileError when an override is wrong.
  MicroNanoSession(const std::string& source_dir, MicroNanoOptions options = {});

  std::vector<MicroNanoRow> run_grids();
  void load(double force_n);  // waits until the weights rest
  // dwell_s: from the end of the move to the readings; absent: what is left of point_s.
  MicroNanoRow visit(const std::array<double, 3>& q_mm, std::optional<double> dwell_s = {});
  MicroNanoRow read_again();  // where it stands; as a visit without a move, its dwell is 0
  void wait(double seconds);
  // Another datum: q = 0, lengths and angles zeroed there; from here on rows count from it. What is
  // given back still counts from the datum before.
  MicroNanoRow zero();

  simulated::MicroNanoPlant& plant() { return *plant_; }
  double now_s() const { return now_s_; }

 private:
  void zero_instruments();
  MicroNanoRow read(double start_s);
  std::array<double, 3> angles_arcsec(double start_s);

  MicroNanoOptions options_;
  std::unique_ptr<simulated::MicroNanoPlant> plant_;
  double now_s_ = 0, force_n_ = 0;
  std::array<double, 3> zero_r_arcsec_{};
  simulated::PoseTruth true_zero_;
};

// A whole campaign on a new plant.
inline std::vector<MicroNanoRow> run_micro_nano_campaign(const std::string& source_dir,
                                                         const MicroNanoOptions& options = {}) {
  return MicroNanoSession(source_dir, options).run_grids();
}

}  // namespace driftwise::testing_support
