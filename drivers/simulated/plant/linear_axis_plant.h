#pragma once
// The linear axis of the published study, case A: a flexure parallelogram with a voice coil and a 5
// nm scale, one laser interferometer on a stabilised support, ten pt1000, a room with air
// conditioning.
//
// One fixed grid of 0.1 s carries everything that has a memory: weather, thermal network,
// stabiliser, slow servo and beam errors. Step k is taken once time has passed its end, with the
// commands known by then; a query reads the last taken steps. So temperatures depend on seed, time
// and commands, never on who asks when. Motion profiles are closed formulas of time. Reading noise
// comes from one generator per instrument and is drawn per reading.
//
// Looking back: up to 200 s before the latest instant; earlier instants get the oldest known state.
// One thread.

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/simulated/plant/disturbance.h"
#include "drivers/simulated/plant/plant.h"
#include "drivers/simulated/plant/truth.h"
#include "drivers/simulated/plant/truth_log.h"

namespace driftwise::simulated {

struct PlantParameters;

class LinearAxisPlant final : public Plant {
 public:
  LinearAxisPlant(PlantParameters parameters, std::uint64_t seed, TimeNs epoch);
  ~LinearAxisPlant() override;

  void advance_to(TimeNs now) override;

  int axis_count() const override { return 1; }
  AxisState axis(int index, TimeNs now) override;
  double axis_min_mm(int index) const override;
  double axis_max_mm(int index) const override;
  void start_move(int index, double target_mm, TimeNs now) override;
  void set_velocity(int index, double mm_per_s, TimeNs now) override;
  void set_servo(int index, bool on, TimeNs now) override;
  void start_reference(int index, TimeNs now) override;
  void halt(TimeNs now) override;

  int interferometer_count() const override { return 1; }
  LengthReading measure_length(int index, TimeNs start, int samples) override;
  double sample_rate_hz() const override;
  void zero_length(int index, TimeNs now) override;
  void set_dead_path_mm(int index, double mm) override;

  double probe_ohm(int input, TimeNs now) override;
  bool has_probe(int input) const override;

  int stabiliser_count() const override { return 1; }
  StabiliserState stabiliser(int index, TimeNs now) override;
  void set_set_point_degc(int index, double degc, TimeNs now) override;
  void set_stabiliser_mode(int index, StabiliserMode mode, double manual_pct, TimeNs now) override;
  void set_stabiliser_tuning(int index, double heat_band_k, double cool_band_k, double ti_s,
                             double td_s, TimeNs now) override;

  // Accidents, for tests of drivers and daemon.
  void break_beam(TimeNs now);  // the length is lost until zeroed
  void set_laser_stable(bool stable, TimeNs now);
  void set_probe_open(int input, bool open, TimeNs now);
  void set_stabiliser_sensor_open(bool open, TimeNs now);
  void add_disturbance(DisturbancePlace place, Disturbance disturbance);

  // The truth, for tests and the demo's last table.
  Truth truth(TimeNs at);
  std::span<const std::string> node_names() const;
  const PlantParameters& parameters() const;
  void attach_truth_log(std::unique_ptr<TruthLog> log);  // from now on rows as truth_log.h says

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace driftwise::simulated
