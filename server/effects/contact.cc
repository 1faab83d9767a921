#include "server/effects/contact.h"

#include <cmath>

namespace driftwise::effects {
namespace {

class ContactState final : public EffectState {
 public:
  std::unique_ptr<EffectState> clone() const override {
    return std::make_unique<ContactState>(*this);
  }
  double step(double /*time_s*/, std::span<const double> inputs) override {
    const double root = std::cbrt(inputs[0]);
    return root * std::abs(root);
  }
};

std::unique_ptr<EffectState> make_contact(std::span<const Quantity> /*parameters*/) {
  return std::make_unique<ContactState>();
}

}  // namespace

EffectKind contact_kind() {
  return {.name = "contact",
          .catalogue_id = "force_nonlinearity",
          .symbol_count = 1,
          .parameters = {},
          .output_unit = "^(2/3)",
          .sentence = "approach of two rounded bodies under a load, by Hertz: the load to 2/3",
          .make = make_contact,
          .memoryless = true};
}

}  // namespace driftwise::effects
