#include "server/effects/creep.h"

#include <algorithm>
#include <cmath>

namespace driftwise::effects {
namespace {

class CreepState final : public EffectState {
 public:
  explicit CreepState(double tau_s) : tau_s_(tau_s) {}
  std::unique_ptr<EffectState> clone() const override {
    return std::make_unique<CreepState>(*this);
  }

  double step(double time_s, std::span<const double> inputs) override {
    const double q = inputs[0], dwell = inputs.size() > 1 ? inputs[1] : 0;
    if (std::isnan(q) || std::isnan(dwell)) return std::nan("");
    if (!started_) {
      started_ = true;
      time_s_ = time_s;
      q_ = q;
      return remainder_;
    }
    const double dt_s = std::max(time_s - time_s_, 0.0);
    const double since_move_s = std::clamp(dwell, 0.0, dt_s);
    remainder_ = (remainder_ * std::exp((since_move_s - dt_s) / tau_s_) + (q - q_)) *
                 std::exp(-since_move_s / tau_s_);
    time_s_ = std::max(time_s_, time_s);
    q_ = q;
    return remainder_;
  }

 private:
  double tau_s_;
  bool started_ = false;
  double time_s_ = 0, q_ = 0, remainder_ = 0;
};

}  // namespace

EffectKind creep_kind() {
  return {
      .name = "creep",
      .catalogue_id = "creep",
      .symbol_count = 2,
      .optional_symbols = 1,
      .parameters = {{"tau", "s", 0.1, 1e6}},
      .output_unit = "mm",
      .sentence =
          "what is left of each move of the first channel, dying away with tau; the "
          "second channel is the dwell since the move's end, the same at every reading where it "
          "is left out (in the first channel's unit)",
      .make = [](std::span<const Quantity> parameters) -> std::unique_ptr<EffectState> {
        return std::make_unique<CreepState>(parameters[0].value);
      },
      .channel_units = {"mm", "s"},
      .observes_path = true,
      .of_coordinate = true};
}

}  // namespace driftwise::effects
