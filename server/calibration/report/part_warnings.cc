#include "server/calibration/report/part_warnings.h"

#include <map>
#include <set>

#include "server/core/data/dataset_parts.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {

std::vector<std::string> part_warnings(const Dataset& dataset, const Model& model) {
  const auto parts = parts_from(dataset.metadata);
  if (parts.empty()) return {};
  std::set<std::string> read;
  for (const auto& output : model.outputs)
    if (is_motor_symbol(output.channel.symbol))
      for (const auto& term : output.terms)
        for (auto& symbol : effects::symbols_of(term)) read.insert(std::move(symbol));
  std::map<std::string, std::string> of_part;  // part -> symbols
  for (const auto& [symbol, part] : parts)
    if (part != "robot" && read.contains(symbol))
      of_part[part] += (of_part[part].empty() ? "" : ", ") + symbol;
  std::vector<std::string> warnings;
  for (const auto& [part, named] : of_part)
    warnings.push_back("thermometers of the " + part + " are in the model: " + named +
                       ". What goes with them is no property of the robot; a model that serves has "
                       "R, the robot's thermometers, instead of T");
  return warnings;
}

}  // namespace driftwise::calibration
