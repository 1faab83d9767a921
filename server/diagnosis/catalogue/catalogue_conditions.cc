// Temperatures and force.

#include <algorithm>
#include <cmath>

#include "server/core/data/reading.h"
#include "server/diagnosis/catalogue/catalogue_builder.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

using effects::AppliesTo;
using effects::Term;

// A rate is a lag in the limit of a short time constant, and what follows one takes a minute or
// two; over one step it is the derivative at the row, over half a step that of the readings as they
// are (rows/prepared.h).
constexpr double kRateSteps = 2, kLongestRateSteps = 8, kLongestRate_s = 120;
constexpr double kShortestLagSteps = 4;
// A stiffness goes with the square of a direction cosine, and the force's direction with another.
constexpr int kExpansionDegree = 2, kCouplingDegree = 3;

Cause of_robot(const std::string& id, const std::string& subject, LinearParameter linear) {
  return {.id = id,
          .subject = subject,
          .where = "robot",
          .applies_to = AppliesTo::robot,
          .linear = linear};
}

// Each product of a pose coordinate with this variable alone, and all together; a robot whose legs
// turn as it moves answers in higher orders too, so all up to each further degree of which the
// simulation has the geometry: x^2 times a temperature of 20 degC is x^2. A rotation counts where
// the simulation reads it as pose: a stage turned by a linear motor has an arm that grows.
void add_pose_products(CatalogueBuilder& builder, Cause cause, const Term& variable,
                       int highest_degree) {
  std::vector<Term> all;
  for (const auto& axis : builder.axes())
    builder.add_terms(cause, {effects::product(power_term(axis), variable)}, kMissing);
  for (int degree = 1; degree <= highest_degree; ++degree) {
    for (const auto& monomial : monomials_of_degree(builder.axes(), degree))
      if (degree == 1 || builder.known(monomial))
        all.push_back(effects::product(monomial, variable));
    builder.add_terms(cause, all, kMissing);
  }
  builder.take_cause(std::move(cause));
}

}  // namespace

void add_temperatures(CatalogueBuilder& builder) {
  if (builder.temperatures().empty()) {
    for (const char* id : {"thermal_offset", "thermal_lag", "thermal_rate", "thermal_expansion"})
      builder.missing(id, "no structure temperature (a channel in degC or K) varies");
    return;
  }
  for (const auto& t : builder.temperatures()) {
    Cause offset = of_robot("thermal_offset", t, LinearParameter::nm_per_k);
    builder.add_terms(offset, {power_term(t)}, kMissing);
    builder.take_cause(std::move(offset));
    add_pose_products(builder, of_robot("thermal_expansion", t, LinearParameter::ppm_per_k),
                      power_term(t), kExpansionDegree);
    if (!builder.timed()) continue;
    Cause lag = of_robot("thermal_lag", t, LinearParameter::none);
    lag.parameter = "tau_s";
    lag.scale = ParameterScale::logarithmic;
    builder.add_values(
        lag, log_grid(std::max(kShortestLagSteps * builder.step_s(), 1.0), builder.length_s() / 2),
        [&](double tau) {
          return std::vector<Term>{call_term("lag", {t}, {{tau, "s"}})};
        });
    builder.take_cause(std::move(lag));
    Cause rate = of_robot("thermal_rate", t, LinearParameter::nm_per_k_per_h);
    const double step_s = std::max(std::round(builder.step_s()), 1.0);
    for (const double over_s : {std::round(builder.step_s() / 2), step_s})
      if (over_s >= 1 && over_s <= step_s)
        builder.add_terms(rate, {call_term("rate", {t}, {{over_s, "s"}})}, kMissing);
    const double longest_s = std::max(kLongestRateSteps * builder.step_s(), kLongestRate_s);
    for (double over_s = std::max(kRateSteps * builder.step_s(), 1.0); over_s <= longest_s;
         over_s *= 2)
      builder.add_terms(rate, {call_term("rate", {t}, {{over_s, "s"}})}, kMissing);
    builder.take_cause(std::move(rate));
  }
  if (builder.axes().empty()) builder.missing("thermal_expansion", "no pose coordinate varies");
  if (!builder.timed())
    for (const char* id : {"thermal_lag", "thermal_rate"})
      builder.missing(id, "the data have no time_s");
}

void add_force(CatalogueBuilder& builder) {
  if (!builder.varies("force")) {
    for (const char* id : {"force_compliance", "force_nonlinearity", "force_position_coupling"})
      builder.missing(id, "no force_N that varies");
    return;
  }
  Cause compliance = of_robot("force_compliance", "F", LinearParameter::nm_per_n);
  builder.add_terms(compliance, {power_term("force")}, kMissing);
  builder.take_cause(std::move(compliance));
  Cause bend = of_robot("force_nonlinearity", "F", LinearParameter::none);
  bend.parameter = "degree";
  for (int d : {2, 3}) builder.add_terms(bend, {power_term("force", d)}, d);
  builder.add_terms(bend, {power_term("force", 2), power_term("force", 3)}, 3);
  if (bend.cells.empty()) builder.add_terms(bend, {power_term("force", 4)}, 4);
  builder.add_terms(bend, {call_term("contact", {"force"})}, 2.0 / 3);
  builder.take_cause(std::move(bend));
  add_pose_products(builder,
                    of_robot("force_position_coupling", "F", LinearParameter::nm_per_n_per_mm),
                    power_term("force"), kCouplingDegree);
  if (builder.axes().empty())
    builder.missing("force_position_coupling", "no pose coordinate varies");
}

}  // namespace driftwise::diagnosis
