#pragma once
// What every simulated cell does alike, whatever its robot: motor axes with scales, interferometers
// with their electronics, thermometers behind a scanner, stabilised supports, accidents, the log of
// the truth. A robot adds where its mirrors are (beam()).
//
// One fixed grid (0.1 s) carries everything that has a memory: weather, thermal network,
// stabilisers, slow servo and beam errors. Step k is taken once time has passed its end, with the
// commands known by then; a query reads the last taken steps. So temperatures depend on seed, time
// and commands, never on who asks when. Motion profiles are closed formulas of time. Reading noise
// comes from one generator per instrument and is drawn per reading.
//
// Looking back: up to 200 s before the latest instant; earlier instants get the oldest known state.
// One thread.

#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "drivers/simulated/plant/cell/disturbance.h"
#include "drivers/simulated/plant/cell/interferometer.h"
#include "drivers/simulated/plant/cell/servo_axis.h"
#include "drivers/simulated/plant/cell/slow_world.h"
#include "drivers/simulated/plant/cell/voltage_sources.h"
#include "drivers/simulated/plant/hidden/hidden_faults.h"
#include "drivers/simulated/plant/plant.h"
#include "drivers/simulated/plant/truth_log.h"

namespace driftwise::simulated {

class CellPlant : public Plant {
 public:
  ~CellPlant() override = default;

  void advance_to(TimeNs now) override;

  int axis_count() const override { return static_cast<int>(axes_.size()); }
  AxisState axis(int index, TimeNs now) override;
  AxisTravel axis_travel(int index) const override;
  void start_move(int index, double target_mm, TimeNs now) override;
  void set_velocity(int index, double mm_per_s, TimeNs now) override;
  void set_servo(int index, bool on, TimeNs now) override;
  void start_reference(int index, TimeNs now) override;
  void halt_axis(int index, TimeNs now) override;

  int interferometer_count() const override { return static_cast<int>(interferometers_.size()); }
  LengthReading measure_length(int index, TimeNs start, int samples) override;
  double sample_rate_hz() const override;
  void zero_length(int index, TimeNs now) override;
  void set_dead_path_mm(int index, double mm) override;

  double probe_ohm(int input, TimeNs now) override;
  bool has_probe(int input) const override;
  double input_volt(int input, TimeNs now) override;
  bool has_voltage(int input) const override { return voltages_.has(input); }

  int stabiliser_count() const override { return static_cast<int>(cell_->stabilisers.size()); }
  StabiliserState stabiliser(int index, TimeNs now) override;
  void set_set_point_degc(int index, double degc, TimeNs now) override;
  void set_stabiliser_mode(int index, StabiliserMode mode, double manual_pct, TimeNs now) override;
  void set_stabiliser_tuning(int index, double heat_band_k, double cool_band_k, double ti_s,
                             double td_s, TimeNs now) override;

  // Accidents, for tests of drivers and daemon.
  virtual void break_beam(TimeNs now, int index = 0);  // the length is lost until zeroed
  // A person opens the box for so long; false: the cell has none.
  bool open_box(double for_s, TimeNs now);
  void set_laser_stable(bool stable, TimeNs now);
  void set_probe_open(int input, bool open, TimeNs now);
  // The input shows this, whatever its sensor sees; nullopt: the sensor again.
  void set_input_volt(int input, std::optional<double> volt, TimeNs now);
  // Of the voltages' columns; throws std::out_of_range. After construction.
  void check_voltages() const { voltages_.check(truth_columns()); }
  void set_stabiliser_sensor_open(bool open, TimeNs now, int index = 0);
  void add_disturbance(DisturbancePlace place, Disturbance disturbance);

  // The truth, for tests and the demo's last table.
  virtual std::vector<std::string> truth_columns() const = 0;
  virtual std::vector<double> truth_values(TimeNs at) = 0;  // in the order of the columns
  std::span<const std::string> node_names() const { return node_names_; }
  const CellParameters& cell() const { return *cell_; }
  // A reading is the mean over so many instants; 1 is cheap, for many campaigns.
  void set_instants_per_reading(int count) { instants_per_reading_ = count; }
  void attach_truth_log(std::unique_ptr<TruthLog> log);  // from now on rows as truth_log.h says

 protected:
  CellPlant(std::shared_ptr<const CellParameters> parameters, std::uint64_t seed, TimeNs epoch);

  // One interferometer at one instant: how far its mirror is and what the world is like.
  struct Beam {
    Frame frame;
    double true_nm = 0;       // mirror against the head
    double disturbed_nm = 0;  // what a disturbance adds to the reading
    double hidden_nm = 0;     // what is hidden in the light's way adds to it
    bool lost = false;        // the light does not come back
  };
  virtual Beam beam(int index, double time_s) const = 0;
  virtual double hidden_force_n(double /*time_s*/) const { return 0; }  // that pulls at the robot
  // Before a command changes the motion or the load: what depends on the past is settled up to now.
  virtual void before_command() {}
  void note(const char* kind) { log(kind, now_); }  // a row of the truth log

  // Of a robot's constructor, last: the interferometers are zeroed without noise.
  void zero_at_start();

  double seconds(TimeNs at) const { return static_cast<double>(at - epoch_) * 1e-9; }
  double now_s() const { return seconds(now_); }
  double disturbed(DisturbancePlace place, const DisturbanceContext& context) const;
  double shown_nm(int index, const Beam& beam) const;  // without the noise of reading
  // What [hidden] adds: of the stage against its scale, of a beam whose mirror is at true_nm.
  double hidden_stage_nm(int axis, const Frame& frame, HiddenContext at) const;
  double hidden_beam_nm(int beam, const Frame& frame, double time_s, double true_nm) const;
  // Of a robot with three axes and six coordinates: those, its own, parts, and what [hidden] adds.
  std::vector<std::string> pose_columns(std::initializer_list<const char*> own) const;
  // Columns and values that [hidden] adds to the truth: "hidden_<name>_nm" (docs/plants/hidden.md).
  void add_hidden_columns(std::vector<std::string>& columns) const;
  void add_hidden_values(const Frame& frame, double time_s, std::vector<double>& values) const;
  static void check(bool good, const char* what);

  std::shared_ptr<const CellParameters> cell_;  // shared: it remembers what it really points at
  std::uint64_t seed_;
  TimeNs epoch_;
  TimeNs now_;
  SlowWorld world_;
  std::vector<ServoAxis> axes_;
  std::vector<Interferometer> interferometers_;
  std::vector<double> true_at_zero_nm_, hidden_at_zero_nm_;
  std::multimap<DisturbancePlace, Disturbance> disturbances_;

 private:
  const AxisParameters& axis_parameters(int index) const;
  const ThermometerParameters* probe(int input, std::size_t& index) const;
  double air_probe_degc(int index, double sampled_s) const;
  void log(const char* kind, TimeNs at);
  double scale_mm(int axis, double time_s) const;
  void follow_motors();

  std::vector<Random> scale_noise_, length_noise_;
  Random scanner_noise_;
  std::vector<std::string> node_names_;
  std::vector<bool> beam_broken_;
  bool laser_stable_ = true;
  int instants_per_reading_ = 16;
  std::set<int> open_probes_;
  VoltageSources voltages_;
  std::map<std::string, std::size_t> truth_places_;  // filled at the first voltage
  double followed_s_ = 0;                            // until then the friction has followed
  HiddenFaults probe_faults_;
  std::unique_ptr<TruthLog> log_;
  double next_tick_s_ = 0;
};

}  // namespace driftwise::simulated
