#include "server/formats/plan/plan_file.h"

#include <toml++/toml.h>

#include <algorithm>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/digest/sha256.h"
#include "server/formats/text/text.h"
#include "server/formats/text/toml_reader.h"
#include "server/formats/text/toml_text.h"

namespace driftwise::formats {
namespace {

using compensation::Variable;
using plans::PlannedRobot;
using plans::ServingPlan;

constexpr int kMostModelId = 2'000'000'000;
constexpr double kMostBandValue = 1e6;

void read_model_id(TomlReader& reader, const char* key, ModelId& out, Need need) {
  int number = 0;
  reader.integer(key, number, 1, kMostModelId, need);
  out.value = number;
}

bool is_plan_robot_id(const std::string& id) {
  return !id.empty() && id.size() <= 64 && std::isalpha(static_cast<unsigned char>(id.front())) &&
         std::ranges::all_of(id, [](unsigned char c) { return std::isalnum(c) || c == '_'; });
}

void read_planned_robot(TomlReader&& reader, PlannedRobot& out) {
  reader.text("id", out.id);
  if (reader.has("id") && !is_plan_robot_id(out.id))
    reader.refuse("id", reasons::kBadId,
                  "found " + shown(out.id) +
                      ", expected a letter, then letters, digits or '_', as before the dot in "
                      "ma.q1_mm");
  read_model_id(reader, "model", out.model, Need::optional);
  reader.text("tool", out.tool);
  reader.finish();
}

// "rx_arcsec": in the unit that requests have.
std::optional<Variable> coordinate_from(const std::string& name) {
  const auto cut = name.rfind('_');
  if (cut == std::string::npos) return std::nullopt;
  const auto variable = compensation::variable_from(name.substr(0, cut));
  if (!variable || *variable == Variable::force ||
      compensation::channel_of(*variable).unit != name.substr(cut + 1))
    return std::nullopt;
  return variable;
}

void read_edges(TomlReader&& reader, bool anchored, plans::Blend& out) {
  std::vector<std::string> names;
  double from = 0, to = 0, fade_to = 0;
  reader.texts("coordinates", names, Need::required);
  reader.number("from", from, {.min = 0, .max = kMostBandValue}, Need::required);
  reader.number("to", to, {.min = 0, .max = kMostBandValue}, Need::required);
  reader.number("fade_to", fade_to, {.min = 0, .max = kMostBandValue},
                anchored ? Need::required : Need::optional);
  double centre = 0;
  std::string side = "both";
  reader.number("centre", centre, {.min = -kMostBandValue, .max = kMostBandValue});
  reader.choice("side", side, {"both", "above", "below"}, Need::optional);
  if (!(from < to))
    reader.refuse("to", reasons::kBadPlan,
                  "found from = " + number_text(from) + " and to = " + number_text(to) +
                      ", expected from below to");
  if (reader.has("fade_to") && !(to < fade_to))
    reader.refuse("fade_to", reasons::kBadPlan,
                  "found " + number_text(fade_to) + ", expected more than to = " + number_text(to));
  for (const auto& name : names) {
    const auto coordinate = coordinate_from(name);
    if (!coordinate) {
      reader.refuse("coordinates", reasons::kBadChannel,
                    "found " + shown(name) +
                        ", expected x_mm, y_mm, z_mm, rx_arcsec, ry_arcsec or rz_arcsec");
      continue;
    }
    if (std::ranges::find(out.band, *coordinate, &plans::BandEdge::coordinate) != out.band.end())
      reader.refuse("coordinates", reasons::kBadPlan,
                    "found " + shown(name) + " twice in the band, expected it once");
    out.band.push_back({*coordinate, from, to,
                        reader.has("fade_to") ? std::optional(fade_to) : std::nullopt, centre,
                        side == "above"   ? plans::BandSide::above
                        : side == "below" ? plans::BandSide::below
                                          : plans::BandSide::both});
  }
  reader.finish();
}

void read_blend(TomlReader&& reader, const std::string& place, ServingPlan& plan,
                TomlProblem& problem) {
  std::string robot;
  ModelId fine;
  plans::Blend blend;
  reader.text("robot", robot);
  read_model_id(reader, "fine", fine, Need::required);
  read_model_id(reader, "coarse", blend.coarse, Need::required);
  reader.truth("anchored", blend.anchored);
  int number = 0;
  for (const auto* table : reader.tables("band"))
    read_edges(TomlReader(*table, place + ", band " + std::to_string(++number), problem),
               blend.anchored, blend);
  if (blend.band.empty())
    reader.refuse("band", reasons::kMissingKey,
                  "expected at least one [[blend.band]] with coordinates, from and to");
  const auto found = std::ranges::find(plan.robots, robot, &PlannedRobot::id);
  if (found == plan.robots.end())
    reader.refuse("robot", reasons::kBadPlan,
                  "found " + shown(robot) + ", expected the id of a [[robot]]");
  else if (found->model.value != 0 || found->blend)
    reader.refuse("robot", reasons::kBadPlan,
                  "robot " + shown(robot) +
                      " has a model already: expected either model in [[robot]] or one [[blend]]");
  else if (fine == blend.coarse)
    reader.refuse("coarse", reasons::kBadPlan,
                  "found model " + std::to_string(fine.value) + " twice, expected two models");
  else {
    found->model = fine;
    found->blend = std::move(blend);
  }
  reader.finish();
}

void read_parasitic_step(TomlReader&& reader, ServingPlan& plan) {
  plans::ParasiticStep step;
  std::vector<std::string> add;
  read_model_id(reader, "model", step.model, Need::required);
  reader.text("from", step.from, Need::required);
  reader.text("to", step.to, Need::required);
  reader.texts("add", add, Need::required);
  reader.finish();
  for (const auto& [key, robot] : {std::pair{"from", step.from}, std::pair{"to", step.to}})
    if (!plan.find(robot))
      reader.refuse(key, reasons::kBadPlan,
                    "found " + shown(robot) + ", expected the id of a [[robot]]");
  if (step.from == step.to)
    reader.refuse("to", reasons::kBadPlan,
                  "found the robot itself, expected the robot whose wanted pose is corrected");
  for (const auto& name : add) {
    const auto coordinate = coordinate_from(name);
    if (!coordinate)
      reader.refuse("add", reasons::kBadChannel,
                    "found " + shown(name) +
                        ", expected x_mm, y_mm, z_mm, rx_arcsec, ry_arcsec or rz_arcsec");
    else if (std::ranges::find(step.add, *coordinate) != step.add.end())
      reader.refuse("add", reasons::kBadPlan, "found " + shown(name) + " twice");
    else
      step.add.push_back(*coordinate);
  }
  plan.steps.push_back(std::move(step));
}

void read_plan_robots(TomlReader& top, ServingPlan& plan, TomlProblem& problem) {
  const auto tables = top.tables("robot");
  for (const auto* table : tables) {
    PlannedRobot robot;
    read_planned_robot(
        TomlReader(*table, "robot " + std::to_string(plan.robots.size() + 1), problem), robot);
    if (plan.find(robot.id))
      top.refuse("robot", reasons::kDuplicateId,
                 "found two robots " + shown(robot.id) + ", expected one");
    if (robot.id.empty() && tables.size() > 1)
      top.refuse("robot", reasons::kMissingKey,
                 "expected an id of every robot where there are several");
    plan.robots.push_back(std::move(robot));
  }
  if (plan.robots.empty() || plan.robots.size() > plans::kMostRobots)
    top.refuse("robot", reasons::kBadPlan,
               "found " + std::to_string(plan.robots.size()) + " robots, expected 1 to " +
                   std::to_string(plans::kMostRobots) + " [[robot]]");
}

void read_plan_z(TomlReader& top, ServingPlan& plan, TomlProblem& problem) {
  const auto* table = top.table("z");
  if (!table) return;
  TomlReader z(*table, "z", problem);
  std::string taken_by;
  z.text("taken_by", taken_by, Need::required);
  z.number("rest_mm", plan.z_rest_mm, {.min = -1e4, .max = 1e4});
  if (!plan.find(taken_by))
    z.refuse("taken_by", reasons::kBadPlan,
             "found " + shown(taken_by) + ", expected the id of a [[robot]]");
  plan.z_taken_by = taken_by;
  z.finish();
}

}  // namespace

Result<ServingPlan> read_plan_file(std::string_view text, const std::string& file_name) {
  if (text.size() > kMostPlanBytes)
    return fail(ErrorCode::invalid_argument, reasons::kTooLong,
                file_name + ": found " + std::to_string(text.size()) + " bytes, expected at most " +
                    std::to_string(kMostPlanBytes));
  toml::table root;
  try {
    root = parse_toml(text, file_name);
  } catch (const toml::parse_error& error) {
    return tl::unexpected(syntax_error(error, file_name));
  }
  TomlProblem problem{file_name, {}};
  TomlReader top(root, "", problem);
  ServingPlan plan;
  top.text("name", plan.name, Need::required);
  if (top.has("name") && (plan.name.empty() || plan.name.size() > 128))
    top.refuse("name", reasons::kBadName,
               "found " + std::to_string(plan.name.size()) + " bytes, expected 1 to 128");
  read_plan_robots(top, plan, problem);
  int number = 0;
  for (const auto* table : top.tables("blend")) {
    const std::string place = "blend " + std::to_string(++number);
    read_blend(TomlReader(*table, place, problem), place, plan, problem);
  }
  for (const auto& robot : plan.robots)
    if (robot.model.value == 0)
      top.refuse("robot", reasons::kBadPlan,
                 "robot " + shown(robot.id) +
                     " has no model: expected model in [[robot]] or a "
                     "[[blend]]");
  number = 0;
  for (const auto* table : top.tables("parasitic"))
    read_parasitic_step(TomlReader(*table, "parasitic " + std::to_string(++number), problem), plan);
  if (plan.steps.size() > plans::kMostSteps)
    top.refuse("parasitic", reasons::kBadPlan,
               "found " + std::to_string(plan.steps.size()) + " steps, expected at most " +
                   std::to_string(plans::kMostSteps));
  read_plan_z(top, plan, problem);
  top.finish();
  if (problem.any()) return tl::unexpected(*problem.first);
  return plan;
}

std::string plan_hash(std::string_view text) { return digest::sha256_hex(text); }

}  // namespace driftwise::formats
