#include "server/effects/thermal_rate.h"

#include <cmath>

namespace driftwise::effects {
namespace {

constexpr double kSecondsPerHour = 3600.0;

class RateState final : public EffectState {
 public:
  RateState(double tau_s, int order) : tau_s_(tau_s), order_(order) {}
  std::unique_ptr<EffectState> clone() const override { return std::make_unique<RateState>(*this); }

  double step(double time_s, std::span<const double> inputs) override {
    const double input = inputs[0];
    if (std::isnan(input)) return input;
    if (!started_) {
      started_ = true;
      time_s_ = time_s;
      input_ = input;
    }
    const double dt_s = time_s - time_s_;
    if (dt_s > 0) {
      // The lags are kept as their distance behind the input, which is small: no digits are lost to
      // 20 degC. For an input of slope s: d1(t) = s tau + c1 e, d2(t) = 2 s tau + (c1 t/tau + c2)
      // e, with e = exp(-t/tau).
      const double ramp = (input - input_) * (tau_s_ / dt_s);
      const double decay = std::exp(-dt_s / tau_s_);
      const double c1 = behind1_ - ramp;
      const double c2 = behind2_ - 2 * ramp;
      behind1_ = ramp + c1 * decay;
      behind2_ = 2 * ramp + (c1 * (dt_s / tau_s_) + c2) * decay;
      time_s_ = time_s;
      input_ = input;
    }
    const double per_hour = kSecondsPerHour / tau_s_;
    return order_ == 1 ? behind1_ * per_hour : (2 * behind1_ - behind2_) * per_hour * per_hour;
  }

 private:
  double tau_s_;
  int order_;
  bool started_ = false;
  double time_s_ = 0, input_ = 0;
  double behind1_ = 0, behind2_ = 0;  // u - L1, u - L2
};

template <int order>
std::unique_ptr<EffectState> make_rate(std::span<const Quantity> parameters) {
  return std::make_unique<RateState>(parameters[0].value, order);
}

}  // namespace

EffectKind thermal_rate_kind() {
  return {.name = "rate",
          .catalogue_id = "thermal_rate",
          .symbol_count = 1,
          .parameters = {{"tau", "s", 1, 1e6}},
          .output_unit = "K/h",
          .sentence = "the channel's rate of change per hour, smoothed over tau",
          .make = make_rate<1>};
}

EffectKind thermal_rate2_kind() {
  return {.name = "rate2",
          .catalogue_id = "thermal_rate",
          .symbol_count = 1,
          .parameters = {{"tau", "s", 1, 1e6}},
          .output_unit = "K/h^2",
          .sentence = "the channel's second derivative per hour squared, smoothed twice over tau",
          .make = make_rate<2>};
}

}  // namespace driftwise::effects
