#include "server/effects/play.h"

#include <algorithm>
#include <cmath>

namespace driftwise::effects {
namespace {

class PlayState final : public EffectState {
 public:
  explicit PlayState(double half_width) : half_width_(half_width) {}
  std::unique_ptr<EffectState> clone() const override { return std::make_unique<PlayState>(*this); }

  double step(double, std::span<const double> inputs) override {
    const double q = inputs[0];
    if (std::isnan(q)) return q;
    if (!started_) {
      started_ = true;
      driven_ = q;
    }
    driven_ = std::min(std::max(driven_, q - half_width_), q + half_width_);
    return driven_ - q;
  }

 private:
  double half_width_;
  bool started_ = false;
  double driven_ = 0;
};

}  // namespace

EffectKind play_kind() {
  return {.name = "play",
          .catalogue_id = "backlash",
          .symbol_count = 1,
          .parameters = {{"width", "nm", 0.1, 1e7, 1e-4, 36000}},
          .output_unit = "mm",
          .sentence =
              "what a play of this full width leaves behind on the channel's path (in its unit)",
          .make = [](std::span<const Quantity> parameters) -> std::unique_ptr<EffectState> {
            return std::make_unique<PlayState>(in_unit_of_channel(parameters[0]) / 2);
          },
          .channel_units = {"mm"},
          .observes_path = true,
          .of_coordinate = true};
}

}  // namespace driftwise::effects
