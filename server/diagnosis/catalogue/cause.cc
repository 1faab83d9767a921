#include "server/diagnosis/catalogue/cause.h"

#include <algorithm>

#include "server/diagnosis/catalogue/catalogue_builder.h"

namespace driftwise::diagnosis {

std::string name_of(const Cause& cause) {
  return cause.subject.empty() ? cause.id : cause.id + " " + cause.subject;
}

bool may_act_on(const Cause& cause, const std::string& output) {
  return cause.outputs.empty() || !is_motor_symbol(output) ||
         std::ranges::find(cause.outputs, output) != cause.outputs.end();
}

std::vector<effects::Term> with_parameter(const std::vector<effects::Term>& terms, double value) {
  std::vector<effects::Term> changed = terms;
  for (auto& term : changed)
    for (auto& factor : term.factors)
      if (auto* call = std::get_if<effects::Call>(&factor); call && !call->parameters.empty())
        call->parameters.front().value = value;
  return changed;
}

bool is_response(const Channel& channel, const std::vector<std::string>& outputs) {
  const std::string& symbol = channel.symbol;
  const auto own = without_robot(symbol);  // another robot's is a condition of this one
  const bool coordinate = is_motor_symbol(own) || is_pose_symbol(own);
  for (const auto& output : outputs)
    if ((symbol == output && !is_motor_symbol(own) && !(coordinate && is_length(channel.unit))) ||
        symbol.starts_with(output + "_"))
      return true;
  return !coordinate && (is_length(channel.unit) || is_angle(channel.unit));
}

Catalogue catalogue_for(const Dataset& dataset, const std::vector<effects::Term>& base,
                        const std::vector<std::string>& excluded) {
  CatalogueBuilder builder(dataset, base, excluded);
  add_geometry(builder);
  add_temperatures(builder);
  add_force(builder);
  add_motion(builder);
  add_probes(builder);
  add_activities(builder);
  add_beams(builder);
  add_time(builder);
  return builder.take();
}

}  // namespace driftwise::diagnosis
