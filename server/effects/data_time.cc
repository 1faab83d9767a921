#include "server/effects/data_time.h"

namespace driftwise::effects {
namespace {

class StepState final : public EffectState {
 public:
  explicit StepState(double instant_s) : instant_s_(instant_s) {}
  std::unique_ptr<EffectState> clone() const override { return std::make_unique<StepState>(*this); }
  double step(double time_s, std::span<const double>) override {
    return time_s < instant_s_ ? 0.0 : 1.0;
  }

 private:
  double instant_s_;
};

class DriftState final : public EffectState {
 public:
  std::unique_ptr<EffectState> clone() const override {
    return std::make_unique<DriftState>(*this);
  }
  double step(double time_s, std::span<const double>) override { return time_s / 3600.0; }
};

}  // namespace

EffectKind step_kind() {
  return {.name = "step",
          .catalogue_id = "step_change",
          .symbol_count = 0,
          .parameters = {{"time", "s", -1e12, 1e12}},
          .output_unit = "1",
          .sentence = "0 before this instant of the data's time, 1 from it on",
          .make = [](std::span<const Quantity> parameters) -> std::unique_ptr<EffectState> {
            return std::make_unique<StepState>(parameters[0].value);
          },
          .applies_to = AppliesTo::dataset,
          .in_data_time = true};
}

EffectKind drift_kind() {
  return {.name = "drift",
          .catalogue_id = "instrument_drift",
          .symbol_count = 0,
          .parameters = {},
          .output_unit = "h",
          .sentence = "the data's time in hours",
          .make = [](std::span<const Quantity>) -> std::unique_ptr<EffectState> {
            return std::make_unique<DriftState>();
          },
          .applies_to = AppliesTo::correction,
          .in_data_time = true};
}

}  // namespace driftwise::effects
