#pragma once
// A plant whose devices say something else than what is: between the plant and the emulators, so
// that what goes over the wire is a well-formed answer. One device lies at a time.

#include <optional>

#include "drivers/simulated/emulators/emulator_kind.h"
#include "drivers/simulated/plant/plant.h"

namespace driftwise::simulated {

struct Lie {
  // Quantity that is false: an axis' readback (mm), a length (nm), a thermometer (ohm), the first
  // angle of an instrument for angles (arcsec), a stabiliser's temperature (degC), the force (N).
  using Of = Quantity;
  enum class Form { jump, scale, value, constant };
  Of of = Of::length;
  int index = 0;  // among its kind; the input of a thermometer
  Form form = Form::jump;
  double amount = 0;  // in the plant's unit; not of constant
};

class LyingPlant final : public Plant {
 public:
  explicit LyingPlant(Plant& plant) : plant_(plant) {}

  void tell(const Lie& lie) {
    lie_ = lie;
    held_.reset();
  }
  void tell_the_truth() { lie_.reset(); }

  void advance_to(TimeNs now) override { plant_.advance_to(now); }
  int axis_count() const override { return plant_.axis_count(); }
  AxisState axis(int index, TimeNs now) override;
  AxisTravel axis_travel(int index) const override { return plant_.axis_travel(index); }
  void start_move(int index, double target_mm, TimeNs now) override {
    plant_.start_move(index, target_mm, now);
  }
  void set_velocity(int index, double mm_per_s, TimeNs now) override {
    plant_.set_velocity(index, mm_per_s, now);
  }
  void set_servo(int index, bool on, TimeNs now) override { plant_.set_servo(index, on, now); }
  void start_reference(int index, TimeNs now) override { plant_.start_reference(index, now); }
  void halt_axis(int index, TimeNs now) override { plant_.halt_axis(index, now); }

  int interferometer_count() const override { return plant_.interferometer_count(); }
  LengthReading measure_length(int index, TimeNs start, int samples) override;
  double sample_rate_hz() const override { return plant_.sample_rate_hz(); }
  void zero_length(int index, TimeNs now) override { plant_.zero_length(index, now); }
  void set_dead_path_mm(int index, double mm) override { plant_.set_dead_path_mm(index, mm); }

  double probe_ohm(int input, TimeNs now) override;
  bool has_probe(int input) const override { return plant_.has_probe(input); }
  double input_volt(int input, TimeNs now) override { return plant_.input_volt(input, now); }
  bool has_voltage(int input) const override { return plant_.has_voltage(input); }

  int collimator_count() const override { return plant_.collimator_count(); }
  AngleReading measure_angle(int index, double average_s, TimeNs end) override;
  bool has_load() const override { return plant_.has_load(); }
  LoadState load(TimeNs now) override;
  void set_load(double newton, TimeNs now) override { plant_.set_load(newton, now); }

  int stabiliser_count() const override { return plant_.stabiliser_count(); }
  StabiliserState stabiliser(int index, TimeNs now) override;
  void set_set_point_degc(int index, double degc, TimeNs now) override {
    plant_.set_set_point_degc(index, degc, now);
  }
  void set_stabiliser_mode(int index, StabiliserMode mode, double manual_pct, TimeNs now) override {
    plant_.set_stabiliser_mode(index, mode, manual_pct, now);
  }
  void set_stabiliser_tuning(int index, double heat_band_k, double cool_band_k, double ti_s,
                             double td_s, TimeNs now) override {
    plant_.set_stabiliser_tuning(index, heat_band_k, cool_band_k, ti_s, td_s, now);
  }

 private:
  // Value to answer in the place of the true one.
  double said(Lie::Of of, int index, double value);

  Plant& plant_;
  std::optional<Lie> lie_;
  std::optional<double> held_;  // of a constant: its first true value
};

}  // namespace driftwise::simulated
