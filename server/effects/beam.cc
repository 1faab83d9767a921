#include "server/effects/beam.h"

#include <cmath>

#include "server/core/units.h"

namespace driftwise::effects {
namespace {

class CosineState final : public EffectState {
 public:
  std::unique_ptr<EffectState> clone() const override {
    return std::make_unique<CosineState>(*this);
  }
  double step(double, std::span<const double> inputs) override {
    // 1 - cos a cos b without cancellation: sin^2(a/2) keeps the digits that 1 - cos a loses
    const double sa = std::sin(rad_from_arcsec(inputs[1]) / 2);
    const double sb = std::sin(rad_from_arcsec(inputs[2]) / 2);
    const double a = 2 * sa * sa, b = 2 * sb * sb;
    return inputs[0] * (a + b - a * b);
  }
};

constexpr double kVacuumWavelengthUm = 0.6329912;  // He-Ne

class AirIndexState final : public EffectState {
 public:
  std::unique_ptr<EffectState> clone() const override {
    return std::make_unique<AirIndexState>(*this);
  }
  double step(double, std::span<const double> inputs) override {
    const double t = inputs[0], pressure_pa = inputs[1] * 100;
    const double s2 = 1 / (kVacuumWavelengthUm * kVacuumWavelengthUm);
    const double standard = (8342.54 + 2406147 / (130 - s2) + 15998 / (38.9 - s2)) * 1e-8;
    const double dry = standard * pressure_pa / 96095.43 *
                       (1 + 1e-8 * (0.601 - 0.00972 * t) * pressure_pa) / (1 + 0.0036610 * t);
    // saturation pressure over water by Magnus' formula (WMO-No. 8, 2018, annex 4.B), 0.1 %
    const double vapour_pa = inputs[2] / 100 * 611.2 * std::exp(17.62 * t / (243.12 + t));
    return (dry - vapour_pa * (3.7345 - 0.0401 * s2) * 1e-10) * 1e6;
  }
};

}  // namespace

EffectKind cosine_error_kind() {
  return {.name = "cosine",
          .catalogue_id = "cosine_error",
          .symbol_count = 3,
          .parameters = {},
          .output_unit = "mm",
          .sentence = "length x (1 - cos cos) of two tilts in arcsec",
          .make = [](std::span<const Quantity>) -> std::unique_ptr<EffectState> {
            return std::make_unique<CosineState>();
          },
          .applies_to = AppliesTo::correction,
          .channel_units = {"mm", "arcsec", "arcsec"},
          .memoryless = true};
}

EffectKind air_index_kind() {
  return {.name = "air_index",
          .catalogue_id = "refractive_index",
          .symbol_count = 3,
          .parameters = {},
          .output_unit = "ppm",
          .sentence = "refractivity of air in ppm from degC, hPa and percent",
          .make = [](std::span<const Quantity>) -> std::unique_ptr<EffectState> {
            return std::make_unique<AirIndexState>();
          },
          .applies_to = AppliesTo::correction,
          .channel_units = {"degC", "hPa", "pct"},
          .memoryless = true};
}

}  // namespace driftwise::effects
