#include "server/effects/lag.h"

#include <cmath>

namespace driftwise::effects {
namespace {

template <int exponent>
class LagState final : public EffectState {
 public:
  explicit LagState(double tau_s) : lag_(tau_s) {}
  std::unique_ptr<EffectState> clone() const override { return std::make_unique<LagState>(*this); }
  double step(double time_s, std::span<const double> inputs) override {
    return lag_.step(time_s, exponent == 2 ? inputs[0] * inputs[0] : inputs[0]);
  }

 private:
  FirstOrderLag lag_;
};

template <int exponent>
std::unique_ptr<EffectState> make_lag(std::span<const Quantity> parameters) {
  return std::make_unique<LagState<exponent>>(parameters[0].value);
}

}  // namespace

double FirstOrderLag::step(double time_s, double input) {
  if (std::isnan(input)) return input;
  if (!started_) {
    started_ = true;
    time_s_ = time_s;
    lagged_ = input_ = input;
    return lagged_;
  }
  const double dt_s = time_s - time_s_;
  if (dt_s > 0) {
    // slope * tau as one quotient: the shift of a ramp behind itself
    const double ramp = (input - input_) * (tau_s_ / dt_s);
    lagged_ = input - ramp + (lagged_ - input_ + ramp) * std::exp(-dt_s / tau_s_);
    time_s_ = time_s;
  }
  input_ = input;
  return lagged_;
}

EffectKind lag_kind() {
  return {.name = "lag",
          .catalogue_id = "thermal_lag",
          .symbol_count = 1,
          .parameters = {{"tau", "s", 1, 1e6}},
          .output_unit = "",
          .sentence = "the channel behind a first-order lag of time constant tau",
          .make = make_lag<1>};
}

EffectKind square_lag_kind() {
  return {.name = "square_lag",
          .catalogue_id = "activity_heating",
          .symbol_count = 1,
          .parameters = {{"tau", "s", 1, 1e6}},
          .output_unit = "^2",
          .sentence = "the channel's square behind a first-order lag of time constant tau",
          .make = make_lag<2>};
}

}  // namespace driftwise::effects
