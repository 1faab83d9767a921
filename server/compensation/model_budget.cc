#include "server/compensation/model_budget.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/compensation/snapshot_builder.h"
#include "server/core/try.h"

namespace driftwise::compensation {
namespace {

constexpr CellTime kAnyInstant{1'000'000'000'000'000'000};

}  // namespace

Result<Snapshot> model_snapshot(const calibration::Model& model, const CellDescription& cell) {
  DRIFTWISE_TRY(auto builder, SnapshotBuilder::create(model, ModelId{0}, cell));
  builder.keep_model_datum();
  builder.observe_middle(kAnyInstant);
  return builder.build(kAnyInstant);
}

std::vector<BudgetPlace> budget_places(const Snapshot& snapshot) {
  std::vector<BudgetPlace> places;
  for (const auto& [name, share] : {std::pair{"centre", 0.5}, std::pair{"corner", 1.0}}) {
    BudgetPlace place{name, {}, {}};
    for (const auto& input : snapshot.inputs) {
      if (!input.variable) continue;
      const double value = input.min + share * (input.max - input.min);
      place.request.set(*input.variable, value);
      place.pose.push_back({channel_of(*input.variable).name(), value});
    }
    places.push_back(std::move(place));
  }
  return places;
}

std::optional<LargestLine> largest_line(const Snapshot& snapshot) {
  std::optional<LargestLine> largest;
  for (const auto& place : budget_places(snapshot)) {
    if (compute_target(snapshot, place.request).refusal != Refusal::none) continue;
    for (std::size_t i = 0; i < snapshot.outputs.size(); ++i) {
      const auto budget = compute_budget(snapshot, place.request, i);
      double variance_nm2 = 0;
      for (std::size_t k = 0; k < budget.lines; ++k)
        variance_nm2 += budget.line[k].u_nm * budget.line[k].u_nm;
      for (std::size_t k = 0; k < budget.lines; ++k)
        if (!largest || budget.line[k].u_nm > largest->u_nm)
          largest = {budget.line[k].source, budget.line[k].u_nm, std::sqrt(variance_nm2)};
    }
  }
  return largest;
}

std::string shown_name(UncertaintySource source) {
  std::string name(to_string(source));
  std::ranges::replace(name, '_', ' ');
  return name;
}

bool is_declared(UncertaintySource source) {
  return source != UncertaintySource::fit && source != UncertaintySource::residual &&
         source != UncertaintySource::extrapolation;
}

}  // namespace driftwise::compensation
