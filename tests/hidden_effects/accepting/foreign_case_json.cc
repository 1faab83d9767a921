#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tests/hidden_effects/accepting/foreign_case.h"

namespace driftwise::hidden {
namespace {

using nlohmann::ordered_json;

ordered_json outputs_json(const std::vector<OutputErrors>& outputs) {
  auto list = ordered_json::array();
  for (const auto& one : outputs)
    list.push_back({{"output", one.output},
                    {"before_nm", one.before_nm},
                    {"after_nm", one.after_nm},
                    {"mean_before_nm", one.mean_before_nm},
                    {"mean_after_nm", one.mean_after_nm},
                    {"inside_before_nm", one.inside_before_nm},
                    {"inside_after_nm", one.inside_after_nm}});
  return list;
}

std::vector<OutputErrors> outputs_from(const ordered_json& list) {
  std::vector<OutputErrors> outputs;
  for (const auto& one : list)
    outputs.push_back({one.at("output"), one.at("before_nm"), one.at("after_nm"),
                       one.at("mean_before_nm"), one.at("mean_after_nm"),
                       one.at("inside_before_nm"), one.at("inside_after_nm")});
  return outputs;
}

}  // namespace

std::string json_line(const ForeignCase& one) {
  const ordered_json line = {{"number", one.number},
                             {"seed", one.order.seed},
                             {"kind", one.order.kind},
                             {"cause", one.order.cause},
                             {"chi2", one.order.chi2},
                             {"robot", one.robot},
                             {"axes", one.axes},
                             {"plan", one.plan},
                             {"noise", one.noise},
                             {"hidden", one.hidden},
                             {"judged_on", one.judged_on},
                             {"rows", one.rows},
                             {"rows_judged", one.rows_judged},
                             {"rows_inside", one.rows_inside},
                             {"verdict", one.verdict},
                             {"named", one.named},
                             {"named_right", one.named_right},
                             {"one_of_a_set", one.one_of_a_set},
                             {"outcome", one.outcome},
                             {"reason", one.reason},
                             {"message", one.message},
                             {"formula", one.formula},
                             {"changed", one.changed},
                             {"outputs", outputs_json(one.outputs)},
                             {"as_instrument", outputs_json(one.outputs_as_instrument)},
                             {"before_move", outputs_json(one.outputs_before_move)},
                             {"cpu_s", one.cpu_s}};
  return line.dump();
}

ForeignCase case_of_line(const std::string& text) try {
  const auto line = ordered_json::parse(text);
  ForeignCase one;
  one.number = line.at("number");
  one.order.seed = line.at("seed");
  one.order.kind = line.at("kind");
  one.order.cause = line.at("cause");
  one.order.chi2 = line.at("chi2");
  one.order.units = "study";
  one.robot = line.at("robot");
  one.axes = line.at("axes");
  one.plan = line.at("plan");
  one.noise = line.at("noise");
  one.hidden = line.at("hidden").get<std::vector<std::string>>();
  one.judged_on = line.at("judged_on");
  one.rows = line.at("rows");
  one.rows_judged = line.at("rows_judged");
  one.rows_inside = line.at("rows_inside");
  one.verdict = line.at("verdict");
  one.named = line.at("named");
  one.named_right = line.at("named_right");
  one.one_of_a_set = line.at("one_of_a_set");
  one.outcome = line.at("outcome");
  one.reason = line.at("reason");
  one.message = line.at("message");
  one.formula = line.at("formula");
  one.changed = line.at("changed");
  one.outputs = outputs_from(line.at("outputs"));
  one.outputs_as_instrument = outputs_from(line.at("as_instrument"));
  one.outputs_before_move = outputs_from(line.at("before_move"));
  one.cpu_s = line.at("cpu_s");
  return one;
} catch (const ordered_json::exception& error) {
  throw std::runtime_error("a line of results is not one of foreign_accept: " +
                           std::string(error.what()));
}

}  // namespace driftwise::hidden
