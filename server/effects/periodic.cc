#include "server/effects/periodic.h"

#include <cmath>
#include <numbers>

namespace driftwise::effects {
namespace {

double phase(double value, double period) {
  return 2 * std::numbers::pi * (std::remainder(value, period) / period);
}

template <bool sine, bool of_time>
class WaveState final : public EffectState {
 public:
  explicit WaveState(double period) : period_(period) {}
  std::unique_ptr<EffectState> clone() const override { return std::make_unique<WaveState>(*this); }
  double step(double time_s, std::span<const double> inputs) override {
    const double angle = phase(of_time ? time_s : inputs[0], period_);
    return sine ? std::sin(angle) : std::cos(angle);
  }

 private:
  double period_;
};

template <bool sine, bool of_time>
std::unique_ptr<EffectState> make_wave(std::span<const Quantity> parameters) {
  const double period = of_time ? parameters[0].value : in_unit_of_channel(parameters[0]);
  return std::make_unique<WaveState<sine, of_time>>(period);
}

template <bool sine>
EffectKind in_coordinate(const char* name) {
  return {.name = name,
          .catalogue_id = "cyclic_error",
          .symbol_count = 1,
          .parameters = {{"period", "nm", 0.1, 1e11, 1e-4, 1e7}},
          .output_unit = "1",
          .sentence = std::string(sine ? "sine" : "cosine") +
                      " of a coordinate, periodic in this many nanometres or arcseconds",
          .make = make_wave<sine, false>,
          .applies_to = AppliesTo::correction,
          .channel_units = {"mm"},
          .memoryless = true,
          .of_coordinate = true};
}

template <bool sine>
EffectKind in_time(const char* name) {
  return {.name = name,
          .catalogue_id = "periodic_disturbance",
          .symbol_count = 0,
          .parameters = {{"period", "s", 0.1, 1e8}},
          .output_unit = "1",
          .sentence = std::string(sine ? "sine" : "cosine") + " of the data's time",
          .make = make_wave<sine, true>,
          .applies_to = AppliesTo::correction,
          .in_data_time = true};
}

}  // namespace

EffectKind sine_kind() { return in_coordinate<true>("sin"); }
EffectKind cosine_wave_kind() { return in_coordinate<false>("cos"); }
EffectKind sine_in_time_kind() { return in_time<true>("sin_t"); }
EffectKind cosine_in_time_kind() { return in_time<false>("cos_t"); }

}  // namespace driftwise::effects
