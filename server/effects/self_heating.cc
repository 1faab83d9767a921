#include "server/effects/self_heating.h"

#include <cmath>

namespace driftwise::effects {
namespace {

class HeatState final : public EffectState {
 public:
  explicit HeatState(double tau_s) : tau_s_(tau_s) {}
  std::unique_ptr<EffectState> clone() const override { return std::make_unique<HeatState>(*this); }

  double step(double time_s, std::span<const double> inputs) override {
    const double q = inputs[0];
    if (std::isnan(q)) return q;
    if (!started_) {
      started_ = true;
      time_s_ = time_s;
    }
    const double dt_s = time_s - time_s_;
    if (dt_s > 0) {
      const double speed = std::abs(q - q_) / dt_s;
      heat_ = speed + (heat_ - speed) * std::exp(-dt_s / tau_s_);
      time_s_ = time_s;
    }
    q_ = q;
    return heat_;
  }

 private:
  double tau_s_;
  bool started_ = false;
  double time_s_ = 0, q_ = 0, heat_ = 0;
};

}  // namespace

EffectKind self_heating_kind() {
  return {.name = "heat",
          .catalogue_id = "self_heating",
          .symbol_count = 1,
          .parameters = {{"tau", "s", 1, 1e6}},
          .output_unit = "mm/s",
          .sentence =
              "the channel's mean speed over the last tau: what its motion heats (its unit, per "
              "second)",
          .make = [](std::span<const Quantity> parameters) -> std::unique_ptr<EffectState> {
            return std::make_unique<HeatState>(parameters[0].value);
          },
          .channel_units = {"mm"},
          .observes_path = true,
          .of_coordinate = true};
}

}  // namespace driftwise::effects
