#pragma once
// The Micro-Nano with an indenter above the MinAngle with a substrate, in one room: case C.2 of the
// published study. Both are the plants of their own cells; here they touch. Physics and choices:
// docs/plants/two-robots.md. Time, noise and looking back: cell_plant.h.
//
// Axes 0, 1, 2 are the Micro-Nano's, 3, 4, 5 the MinAngle's. Lengths 0, 1, 2 are the Micro-Nano's
// interferometers, 3 to 5 the MinAngle's, 6 its touch probe; angles 0, 1 the Micro-Nano's
// autocollimators, 2, 3 the MinAngle's, 4 its inclinometer. Scanner inputs 101 .. are the
// Micro-Nano's cell's, 201 .. the MinAngle's.

#include <deque>

#include "drivers/simulated/plant/micro_nano/micro_nano_plant.h"
#include "drivers/simulated/plant/min_angle/min_angle_plant.h"
#include "drivers/simulated/plant/two_robots/contact_force.h"

namespace driftwise::simulated {

// Places of tool and substrate, and what they do to one another.
struct ContactTruth {
  double gap_nm = 0;  // tip above the substrate; below 0: without contact it would be in
  double push_nm = 0, force_n = 0;  // of the upper robot
  std::array<double, 3>
      tip_mm{};  // in the base's frame, upper robot at 0: x, y; z from the cube's 0
  double rx_arcsec = 0, ry_arcsec = 0;  // of the substrate
};

struct MicroscopeRow {
  int id = 0;  // craters in the order of their first touch, from 1
  double x_um = 0, y_um = 0, diagonal_um = 0;
  double pixel_nm = 0, marking_px = 0;
  int pictures_joined = 0;
};

class TwoRobotsPlant final : public MicroNanoPlant {
 public:
  TwoRobotsPlant(TwoRobotsParameters parameters, std::uint64_t seed, TimeNs epoch);

  void advance_to(TimeNs now) override;

  int axis_count() const override { return kUpperAxes + lower_.axis_count(); }
  AxisState axis(int index, TimeNs now) override;
  AxisTravel axis_travel(int index) const override;
  void start_move(int index, double target_mm, TimeNs now) override;
  void set_velocity(int index, double mm_per_s, TimeNs now) override;
  void set_servo(int index, bool on, TimeNs now) override;
  void start_reference(int index, TimeNs now) override;
  void halt_axis(int index, TimeNs now) override;

  int interferometer_count() const override {
    return kUpperLengths + lower_.interferometer_count();
  }
  LengthReading measure_length(int index, TimeNs start, int samples) override;
  void zero_length(int index, TimeNs now) override;
  void set_dead_path_mm(int index, double mm) override;
  void break_beam(TimeNs now, int index = 0) override;
  int collimator_count() const override { return kUpperAngles + lower_.collimator_count(); }
  AngleReading measure_angle(int index, double average_s, TimeNs end) override;
  double probe_ohm(int input, TimeNs now) override;
  bool has_probe(int input) const override;

  // Accident: somebody knocks at the table; the upper robot swings about where it holds.
  void knock(double amplitude_nm, TimeNs now);

  // Parts between the robots, for a calibration at strokes that would touch: they raise the upper
  // one by so much. 0: as for indentation.
  void set_spacers_mm(double height_mm, TimeNs now);

  // A fresh substrate, glued on by hand with these tilts; the one before went with its craters.
  void set_substrate_arcsec(double rx_arcsec, double ry_arcsec, TimeNs now);

  // The craters as the microscope shows them: from the one called origin, with its scale and with
  // the marking's error; the same for the same craters.
  std::vector<MicroscopeRow> microscope(int origin) const;

  ContactTruth contact(TimeNs at);
  const std::vector<Crater>& craters() const { return craters_; }
  double substrate_rx_arcsec() const;  // of the substrate on the lower robot
  double substrate_ry_arcsec() const;
  double lever_mm() const { return lever_mm_; }
  MinAnglePlant& lower() { return lower_; }

  std::vector<std::string> truth_columns() const override;
  std::vector<double> truth_values(TimeNs at) override;

 private:
  static constexpr int kUpperAxes = 3, kUpperLengths = 3, kUpperAngles = 2;
  struct Push {
    double time_s = 0, push_nm = 0, force_n = 0;
  };
  struct Knock {
    double time_s = 0, amplitude_nm = 0;
  };
  struct Place {
    double gap_nm = 0;                  // without contact
    Vec3 tip_mm;                        // in the base's frame
    double sub_x_mm = 0, sub_y_mm = 0;  // of the tip, on the substrate
    double rx_rad = 0, ry_rad = 0;      // of the substrate
  };
  bool is_lower_axis(int index) const;
  double push_nm(double time_s) const;  // by contact and knocks
  double held_nm(double time_s) const;  // by contact alone
  Place place(double time_s) const;
  void step(double time_s);
  Crater& crater_at(const Place& at);

  const TwoRobotsParameters parameters_;
  MinAnglePlant lower_;
  HoldingServo servo_;
  double gap_mm_ = 0, spacers_mm_ = 0, lever_mm_ = 0, tilt_rx_rad_ = 0, tilt_ry_rad_ = 0;
  std::vector<Crater> craters_;
  std::deque<Push> pushes_;
  std::vector<Knock> knocks_;
  double next_step_s_ = 0, last_looked_s_ = -1e9, last_command_s_ = -1e9, gap_nm_ = 1e9;
  bool touching_ = false;
};

}  // namespace driftwise::simulated
