#include "tests/statistics/served_case.h"

#include <stdexcept>

#include "server/compensation/snapshot_builder.h"
#include "server/core/units.h"
#include "server/formats/formula/formula.h"
#include "server/formats/model/model_json.h"

namespace driftwise::statistics {
namespace {

template <class T>
T value_or_throw(Result<T> result, const char* what) {
  if (!result) throw std::runtime_error(std::string(what) + ": " + result.error().message);
  return std::move(*result);
}

}  // namespace

Served serve_and_judge(const SimulatedCase& simulated) {
  Served served;
  const auto fitted =
      value_or_throw(formats::fit_formula(simulated.dataset, simulated.formula, {}), "fit");
  served.model =
      value_or_throw(formats::read_model_json(formats::write_model_json(fitted)), "model");
  auto builder = value_or_throw(
      compensation::SnapshotBuilder::create(served.model, ModelId{1}, simulated.cell), "snapshot");
  builder.keep_model_datum();
  for (std::size_t i = 0; i < simulated.targets.size(); ++i) {
    const auto& asked = simulated.targets[i];
    builder.observe(asked.conditions, asked.at);
    const auto snapshot = builder.build(asked.at);
    const auto target = compensation::compute_target(snapshot, asked.true_pose);
    if (target.refusal != compensation::Refusal::none)
      throw std::runtime_error(compensation::refusal_error(snapshot, target).message);
    for (std::size_t o = 0; o < target.outputs; ++o)
      served.outcomes.push_back(
          {.target = i,
           .output = o,
           .error_nm = nm_from_mm(target.q_mm[o] - asked.q_mm[o]),
           .u_nm = target.u_nm[o],
           .since_zero_h =
               std::chrono::duration<double, std::ratio<3600>>(asked.at - simulated.zero_at)
                   .count(),
           .inside_domain = (target.flags & compensation::kOutsideDomain) == 0,
           .budget = compensation::compute_budget(snapshot, asked.true_pose, o)});
  }
  return served;
}

}  // namespace driftwise::statistics
