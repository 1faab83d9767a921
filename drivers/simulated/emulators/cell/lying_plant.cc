#include "drivers/simulated/emulators/cell/lying_plant.h"

namespace driftwise::simulated {

double LyingPlant::said(Lie::Of of, int index, double value) {
  if (!lie_ || lie_->of != of || lie_->index != index) return value;
  switch (lie_->form) {
    case Lie::Form::jump:
      return value + lie_->amount;
    case Lie::Form::scale:
      return value * lie_->amount;
    case Lie::Form::value:
      return lie_->amount;
    case Lie::Form::constant:
      if (!held_) held_ = value;
      return *held_;
  }
  return value;
}

AxisState LyingPlant::axis(int index, TimeNs now) {
  AxisState state = plant_.axis(index, now);
  state.q_mm = said(Lie::Of::axis, index, state.q_mm);
  return state;
}

LengthReading LyingPlant::measure_length(int index, TimeNs start, int samples) {
  LengthReading reading = plant_.measure_length(index, start, samples);
  reading.mean_nm = said(Lie::Of::length, index, reading.mean_nm);
  return reading;
}

double LyingPlant::probe_ohm(int input, TimeNs now) {
  return said(Lie::Of::probe, input, plant_.probe_ohm(input, now));
}

AngleReading LyingPlant::measure_angle(int index, double average_s, TimeNs end) {
  AngleReading reading = plant_.measure_angle(index, average_s, end);
  reading.y_arcsec = said(Lie::Of::angle, index, reading.y_arcsec);
  return reading;
}

LoadState LyingPlant::load(TimeNs now) {
  LoadState state = plant_.load(now);
  state.newton = said(Lie::Of::load, 0, state.newton);
  return state;
}

StabiliserState LyingPlant::stabiliser(int index, TimeNs now) {
  StabiliserState state = plant_.stabiliser(index, now);
  state.process_degc = said(Lie::Of::stabiliser, index, state.process_degc);
  return state;
}

}  // namespace driftwise::simulated
