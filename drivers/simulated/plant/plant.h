#pragma once
// What the emulated devices can ask of the simulated cell's physics. One implementation per robot.
//
// No code is shared with server/ or with the drivers' codecs. Time is cell UTC in nanoseconds;
// every call that takes a time first integrates the plant up to it, and time never runs back (an
// earlier instant is answered as "now"). One thread. Deterministic: the same seed and the same
// sequence of calls give the same numbers, and the room's weather and the thermal network depend on
// the seed and the time only, never on who asks when.

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace driftwise::simulated {

using TimeNs = std::int64_t;

struct AxisState {
  double q_mm = 0;  // what the scale reads now (quantised, with its noise)
  double commanded_mm = 0;
  bool moving = false;     // the profile is under way
  bool on_target = false;  // within the window of the target since the window time
  bool referenced = false;
  bool referencing = false;
  bool servo = true;
};

struct LengthReading {  // an average over n samples, as the interferometer's electronics gives it
  double mean_nm = 0, std_nm = 0;
  double air_degc = 0, air_age_s = 0;
  double level_pct = 0;
  bool beam_broken = false;  // since the last zero: the length is lost
  bool laser_stable = true;
  TimeNs start = 0, end = 0;
};

struct AngleReading {  // of an autocollimator, its own axes: an average that ends at `end`
  double y_arcsec = 0, z_arcsec = 0;
  bool power_wrong = false;     // too little light comes back
  bool position_wrong = false;  // the spot lies beyond the detector
  TimeNs end = 0;
};

struct LoadState {      // of the device that pulls at the end-effector
  double newton = 0;    // what hangs: nominal mass x 9.81
  bool resting = true;  // the weights have been changed and hang still
  bool jammed = false;
  double max_newton = 0;
};

struct StabiliserState {
  double process_degc = 0, set_point_degc = 0;
  double heat_pct = 0, cool_pct = 0;
  bool sensor_open = false;
};

struct AxisTravel {  // hard travel of the controller
  double min_mm = 0, max_mm = 0;
};

// One interface per kind of device; a device's emulator knows its own only.
class PlantAxes {
 public:
  virtual int axis_count() const = 0;
  virtual AxisState axis(int index, TimeNs now) = 0;
  virtual AxisTravel axis_travel(int index) const = 0;
  virtual void start_move(int index, double target_mm,
                          TimeNs now) = 0;  // the caller has checked the range
  virtual void set_velocity(int index, double mm_per_s, TimeNs now) = 0;
  virtual void set_servo(int index, bool on, TimeNs now) = 0;
  virtual void start_reference(int index, TimeNs now) = 0;  // takes its time; see axis()
  virtual void halt_axis(int index, TimeNs now) = 0;        // where it is now

 protected:
  ~PlantAxes() = default;
};

class PlantLengths {
 public:
  virtual int interferometer_count() const = 0;
  // The average over the samples taken in [start, start + n / rate]; called at or after its end.
  virtual LengthReading measure_length(int index, TimeNs start, int samples) = 0;
  virtual double sample_rate_hz() const = 0;
  virtual void zero_length(int index, TimeNs now) = 0;
  virtual void set_dead_path_mm(int index, double mm) = 0;

 protected:
  ~PlantLengths() = default;
};

// Robots without rotations keep these.
class PlantAngles {
 public:
  virtual int collimator_count() const { return 0; }
  virtual AngleReading measure_angle(int /*index*/, double /*average_s*/, TimeNs /*end*/) {
    throw std::out_of_range("this plant has no autocollimator");
  }

 protected:
  ~PlantAngles() = default;
};

class PlantThermometers {
 public:
  // Four-wire resistance of the pt1000 on scanner input 101, 102, ..; NaN when the probe is open.
  virtual double probe_ohm(int input, TimeNs now) = 0;
  virtual bool has_probe(int input) const = 0;
  // Voltage between the wires of an input to which a sensor is connected.
  virtual double input_volt(int /*input*/, TimeNs /*now*/) { return 0; }
  virtual bool has_voltage(int /*input*/) const { return false; }

 protected:
  ~PlantThermometers() = default;
};

// Robots without a load keep these.
class PlantLoad {
 public:
  virtual bool has_load() const { return false; }
  virtual LoadState load(TimeNs /*now*/) { return {}; }
  // Weights are changed until newton hangs; see load(). The caller has checked the range.
  virtual void set_load(double /*newton*/, TimeNs /*now*/) {
    throw std::out_of_range("this plant has no load");
  }

 protected:
  ~PlantLoad() = default;
};

class PlantStabilisers {
 public:
  virtual int stabiliser_count() const = 0;
  virtual StabiliserState stabiliser(int index, TimeNs now) = 0;
  virtual void set_set_point_degc(int index, double degc, TimeNs now) = 0;
  enum class StabiliserMode { automatic, manual, off };
  virtual void set_stabiliser_mode(int index, StabiliserMode mode, double manual_pct,
                                   TimeNs now) = 0;
  // Heat and cool proportional bands in kelvin, integral and derivative times in seconds (0: off).
  virtual void set_stabiliser_tuning(int index, double heat_band_k, double cool_band_k, double ti_s,
                                     double td_s, TimeNs now) = 0;

 protected:
  ~PlantStabilisers() = default;
};

class Plant : public PlantAxes,
              public PlantLengths,
              public PlantAngles,
              public PlantThermometers,
              public PlantLoad,
              public PlantStabilisers {
 public:
  virtual ~Plant() = default;
  virtual void advance_to(TimeNs now) = 0;
};

}  // namespace driftwise::simulated
