#include "server/application/ports/run_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "server/core/reasons.h"

namespace driftwise::application {
namespace {

// One list of names for both directions.
template <class Rules, class Visit>
void each_rule(Rules& rules, Visit visit) {
  visit("readings_per_point", rules.readings_per_point, 1, 1000);
  visit("max_spread_nm", rules.max_spread_nm, 0.0, 1e9);
  visit("max_rereads", rules.max_rereads, 0, 1000);
  visit("max_reapproaches", rules.max_reapproaches, 0, 1000);
  visit("max_requeues", rules.max_requeues, 0, 1000);
  visit("reapproach_mm", rules.reapproach_mm, 0.0, 1e4);
  visit("settle_s", rules.settle_s, 0.0, 1e5);
  visit("in_position_nm", rules.in_position_nm, 0.0, 1e9);
  visit("quiet_nm", rules.quiet_nm, 0.0, 1e9);
  visit("move_timeout_s", rules.move_timeout_s, 0.0, 1e5);
  visit("max_temperature_age_s", rules.max_temperature_age_s, 0.0, 1e6);
  visit("max_given_up_share", rules.max_given_up_share, 0.0, 1.0);
}

// A coordinate that two instruments give, with their ids; empty: none.
std::string given_twice(const CellDescription& cell) {
  std::map<std::string, std::string> givers;
  for (const auto& device : cell.devices) {
    std::vector<Channel> given;
    if (const auto* length = device.length()) given.push_back(length->channel);
    for (const auto& angle : device.angles()) given.push_back(angle.channel);
    for (const auto& channel : given) {
      const auto [first, is_new] = givers.try_emplace(channel.name(), device.id);
      if (!is_new)
        return fmt::format("{} is given by '{}' and by '{}'", channel.name(), first->second,
                           device.id);
    }
  }
  return {};
}

}  // namespace

std::string write_run_plan(const RunPlan& plan) {
  nlohmann::ordered_json json;
  each_rule(plan.rules,
            [&json](const char* name, const auto& value, auto, auto) { json[name] = value; });
  if (plan.rules.max_spread_arcsec != RunRules{}.max_spread_arcsec)
    json["max_spread_arcsec"] = plan.rules.max_spread_arcsec;
  json["park"] = plan.rules.park;
  json["compensate"] = plan.compensate;
  if (plan.compensate_with) json["compensate_with"] = plan.compensate_with->value;
  if (!plan.setup.empty()) json["setup"] = plan.setup;
  if (plan.served_at_start) json["served_at_start"] = plan.served_at_start->value;
  if (plan.plan_at_start) json["plan_at_start"] = plan.plan_at_start->value;
  return json.dump();
}

std::string write_waiting_plan(const std::optional<RunRules>& rules, const std::string& setup) {
  RunPlan plan;
  plan.setup = setup;
  if (rules) {
    plan.rules = *rules;
    return write_run_plan(plan);
  }
  return setup.empty() ? std::string() : nlohmann::json{{"setup", setup}}.dump();
}

bool states_rules(const std::string& text) {
  return nlohmann::json::parse(text, nullptr, false).contains("readings_per_point");
}

Result<RunPlan> read_run_plan(const std::string& text) {
  RunPlan plan;
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object())
    return fail(ErrorCode::data_loss, reasons::kBadRunPlan,
                fmt::format("the stored rules are no JSON object: '{}'", text));
  std::string bad;
  each_rule(plan.rules, [&json, &bad](const char* name, auto& value, auto, auto) {
    if (!json.contains(name)) return;
    if (json[name].is_number())
      json[name].get_to(value);
    else
      bad = name;
  });
  if (const auto found = json.find("max_spread_arcsec"); found != json.end() && found->is_number())
    plan.rules.max_spread_arcsec = *found;
  if (const auto found = json.find("park"); found != json.end() && found->is_boolean())
    plan.rules.park = *found;
  if (const auto found = json.find("compensate"); found != json.end() && found->is_boolean())
    plan.compensate = *found;
  if (const auto found = json.find("compensate_with");
      found != json.end() && found->is_number_integer())
    plan.compensate_with = ModelId{found->get<std::int64_t>()};
  if (const auto found = json.find("served_at_start");
      found != json.end() && found->is_number_integer())
    plan.served_at_start = ModelId{found->get<std::int64_t>()};
  if (const auto found = json.find("plan_at_start");
      found != json.end() && found->is_number_integer())
    plan.plan_at_start = PlanId{found->get<std::int64_t>()};
  if (const auto found = json.find("setup"); found != json.end() && found->is_string())
    plan.setup = found->get<std::string>();
  if (!bad.empty())
    return fail(ErrorCode::data_loss, reasons::kBadRunPlan,
                fmt::format("the stored rule {} is no number", bad));
  return plan;
}

Compensation compensation_of(const RunRecord& run) {
  const auto plan = read_run_plan(run.rules_json);
  if (!plan || !plan->compensate) return {};
  return {true, plan->compensate_with ? plan->compensate_with : plan->served_at_start,
          plan->plan_at_start};
}

std::string compensation_text(const Compensation& of) {
  if (!of.compensated) return "none";
  if (of.plan) return fmt::format("plan {}", of.plan->value);
  return of.model ? fmt::format("model {}", of.model->value) : "the model that served";
}

std::string setup_of(const RunRecord& run) {
  const auto plan = read_run_plan(run.rules_json);
  return plan ? plan->setup : std::string();
}

Result<void> check_setup(const CellDescription& cell, const std::string& setup) {
  const std::string twice = setup.empty() ? given_twice(cell) : std::string();
  if ((setup.empty() && twice.empty()) ||
      std::ranges::find(cell.setups, setup, &SetupDescription::name) != cell.setups.end())
    return {};
  std::string known;
  for (const auto& one : cell.setups) known += (known.empty() ? "" : ", ") + one.name;
  if (!twice.empty())
    return fail(ErrorCode::invalid_argument, reasons::kNoSuchSetup,
                fmt::format("setup: found none, expected one of cell '{}': {}; {}", cell.name,
                            known, twice));
  return fail(ErrorCode::invalid_argument, reasons::kNoSuchSetup,
              fmt::format("setup: found '{}', expected one of cell '{}': {}", setup, cell.name,
                          known.empty() ? "it has none, add [[setup]] to the cell file" : known));
}

Result<void> check_rules(const RunRules& rules) {
  Result<void> result;
  each_rule(rules, [&result](const char* name, auto value, auto low, auto high) {
    if (result && !(value >= low && value <= high))
      result = fail(ErrorCode::invalid_argument, reasons::kBadRules,
                    fmt::format("{} = {}, expected {} to {}", name, value, low, high));
  });
  return result;
}

}  // namespace driftwise::application
