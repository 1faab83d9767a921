#include "server/formats/indentation/procedure_json.h"

#include <nlohmann/json.hpp>

#include "server/core/reasons.h"
#include "server/formats/text/json_place.h"

namespace driftwise::formats {
namespace {

using Json = nlohmann::ordered_json;
using namespace indentation;

constexpr Stage kStages[] = {Stage::align, Stage::zero, Stage::indents, Stage::microscope};

Json touch_json(const TouchRecord& t) {
  return {{"x_mm", t.x_mm}, {"y_mm", t.y_mm},   {"height_mm", t.height_mm},
          {"u_nm", t.u_nm}, {"steps", t.steps}, {"contact", t.contact}};
}

TouchRecord touch_from(const Json& json) {
  return {.x_mm = json.at("x_mm"),
          .y_mm = json.at("y_mm"),
          .height_mm = json.at("height_mm"),
          .u_nm = json.at("u_nm"),
          .steps = json.at("steps"),
          .contact = json.at("contact")};
}

Json values_json(const std::vector<std::pair<std::string, double>>& values) {
  Json json = Json::object();
  for (const auto& [name, value] : values) json[name] = value;
  return json;
}

std::vector<std::pair<std::string, double>> values_from(const Json& json) {
  std::vector<std::pair<std::string, double>> values;
  for (const auto& [name, value] : json.items()) values.emplace_back(name, value.get<double>());
  return values;
}

Json indent_json(const MadeIndent& one) {
  Json json{{"id", one.planned.id},
            {"line", one.planned.line == Line::x ? "x" : "y"},
            {"at_um", one.planned.at_um},
            {"closed_loop", one.planned.closed_loop},
            {"placed_x_um", one.placed_x_um},
            {"placed_y_um", one.placed_y_um},
            {"rx_arcsec", one.rx_arcsec},
            {"ry_arcsec", one.ry_arcsec},
            {"by", one.by}};
  json["touch"] = touch_json(one.touch);
  return json;
}

MadeIndent indent_from(const Json& json) {
  return {.planned = {.id = json.at("id"),
                      .line = json.at("line") == "x" ? Line::x : Line::y,
                      .at_um = json.at("at_um"),
                      .closed_loop = json.at("closed_loop")},
          .touch = touch_from(json.at("touch")),
          .placed_x_um = json.at("placed_x_um"),
          .placed_y_um = json.at("placed_y_um"),
          .rx_arcsec = json.at("rx_arcsec"),
          .ry_arcsec = json.at("ry_arcsec"),
          .by = json.at("by")};
}

Stage stage_from(const std::string& text) {
  for (const Stage one : kStages)
    if (to_string(one) == text) return one;
  throw std::invalid_argument("stage '" + text + "' is not known");
}

Json contact_json(const ContactRecord& one) {
  Json json = touch_json(one.touch);
  json.update({{"stage", to_string(one.stage)},
               {"round", one.round},
               {"indent", one.indent},
               {"rx_arcsec", one.rx_arcsec},
               {"ry_arcsec", one.ry_arcsec},
               {"by", one.by},
               {"at", one.at},
               {"trouble", one.trouble}});
  return json;
}

ContactRecord contact_from(const Json& json) {
  return {.touch = touch_from(json),
          .stage = stage_from(json.at("stage")),
          .round = json.at("round"),
          .indent = json.at("indent"),
          .rx_arcsec = json.at("rx_arcsec"),
          .ry_arcsec = json.at("ry_arcsec"),
          .by = json.at("by"),
          .at = json.at("at"),
          .trouble = json.at("trouble")};
}

Json round_json(const RoundRecord& one) {
  return {{"round", one.round},
          {"accepted", one.accepted},
          {"spread_nm", one.spread_nm},
          {"rx_arcsec", one.rx_arcsec},
          {"ry_arcsec", one.ry_arcsec},
          {"height_mm", one.height_mm},
          {"by", one.by},
          {"at", one.at}};
}

RoundRecord round_from(const Json& json) {
  return {.round = json.at("round"),
          .accepted = json.at("accepted"),
          .spread_nm = json.at("spread_nm"),
          .rx_arcsec = json.at("rx_arcsec"),
          .ry_arcsec = json.at("ry_arcsec"),
          .height_mm = json.at("height_mm"),
          .by = json.at("by"),
          .at = json.at("at")};
}

ProcedureRecord record_from(const Json& json) {
  ProcedureRecord r;
  r.key = json.value("key", std::string());
  r.stage = stage_from(json.at("stage"));
  r.tool = json.at("tool");
  r.revision = json.value("revision", std::int64_t{0});  // of a record from before it: 0
  r.contacts = json.at("contacts");
  r.in_contact = json.at("in_contact");
  r.aside_um = json.at("aside_um");
  r.corrections = json.at("corrections");
  r.anew = json.value("anew", 0);
  r.rx_arcsec = json.at("rx_arcsec");
  r.ry_arcsec = json.at("ry_arcsec");
  r.height_mm = json.at("height_mm");
  r.touched = json.at("touched");
  if (const auto by = json.find("heights_by"); by != json.end())
    r.heights_by = HeightBasis{.work_mm = by->at("work_mm"), .source = by->at("source")};
  r.spread_nm = json.at("spread_nm");
  r.log = json.at("log").get<std::vector<std::string>>();
  r.by = json.at("by");
  for (const auto& one : json.at("touches")) r.touches.push_back(touch_from(one));
  const Json& zero = json.at("zero");
  r.zero = touch_from(zero.at("touch"));
  r.zero_here = {.x_mm = zero.at("x_mm"),
                 .y_mm = zero.at("y_mm"),
                 .z_mm = zero.at("z_mm"),
                 .rx_arcsec = zero.at("rx_arcsec"),
                 .ry_arcsec = zero.at("ry_arcsec"),
                 .motors_mm = values_from(zero.at("motors_mm")),
                 .degc = values_from(zero.at("temperatures_degC"))};
  for (const auto& one : json.at("indents")) r.indents.push_back(indent_from(one));
  // Of no record written before these lists were.
  if (const auto list = json.find("contact_list"); list != json.end())
    for (const auto& one : *list) r.contact_list.push_back(contact_from(one));
  if (const auto list = json.find("rounds"); list != json.end())
    for (const auto& one : *list) r.rounds.push_back(round_from(one));
  return r;
}

}  // namespace

std::string procedure_json(const ProcedureRecord& r) {
  Json json{{"driftwise_indentation", 1},
            {"key", r.key},
            {"revision", r.revision},
            {"stage", to_string(r.stage)},
            {"tool", r.tool},
            {"contacts", r.contacts},
            {"in_contact", r.in_contact},
            {"aside_um", r.aside_um},
            {"corrections", r.corrections},
            {"anew", r.anew},
            {"rx_arcsec", r.rx_arcsec},
            {"ry_arcsec", r.ry_arcsec},
            {"height_mm", r.height_mm},
            {"touched", r.touched},
            {"spread_nm", r.spread_nm},
            {"by", r.by}};
  if (r.heights_by)
    json["heights_by"] = {{"work_mm", r.heights_by->work_mm}, {"source", r.heights_by->source}};
  json["log"] = r.log;
  json["touches"] = Json::array();
  for (const auto& one : r.touches) json["touches"].push_back(touch_json(one));
  const auto& here = r.zero_here;
  Json zero{{"x_mm", here.x_mm},
            {"y_mm", here.y_mm},
            {"z_mm", here.z_mm},
            {"rx_arcsec", here.rx_arcsec},
            {"ry_arcsec", here.ry_arcsec}};
  zero["motors_mm"] = values_json(here.motors_mm);
  zero["temperatures_degC"] = values_json(here.degc);
  zero["touch"] = touch_json(r.zero);
  json["zero"] = std::move(zero);
  json["indents"] = Json::array();
  for (const auto& one : r.indents) json["indents"].push_back(indent_json(one));
  json["contact_list"] = Json::array();
  for (const auto& one : r.contact_list) json["contact_list"].push_back(contact_json(one));
  json["rounds"] = Json::array();
  for (const auto& one : r.rounds) json["rounds"].push_back(round_json(one));
  return json.dump(1) + "\n";
}

Result<ProcedureRecord> read_procedure_json(std::string_view text, const std::string& file_name) {
  const auto json = parse_ordered_json(text);
  if (!json)
    return fail(ErrorCode::data_loss, reasons::kJsonSyntax,
                file_name + ": damaged at " + json.error().message +
                    ": put it aside and begin a new indentation on a fresh surface");
  try {
    return record_from(*json);
  } catch (const std::exception& error) {  // nlohmann's, with the key; ours
    return fail(ErrorCode::data_loss, reasons::kBadValue,
                file_name + ": " + error.what() +
                    ": put it aside and begin a new indentation on a fresh surface");
  }
}

}  // namespace driftwise::formats
