#include "clients/cli/commands/runs/report_data.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>

#include "clients/cli/commands/record/record_file.h"
#include "clients/cli/core/console.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/text.h"
#include "clients/cli/pages/run_text.h"

namespace driftwise::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string base64(const std::string& bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    const std::size_t here = std::min<std::size_t>(3, bytes.size() - at);
    std::uint32_t group = 0;
    for (std::size_t i = 0; i < 3; ++i)
      group = group << 8 | (i < here ? static_cast<unsigned char>(bytes[at + i]) : 0u);
    for (std::size_t i = 0; i < 4; ++i)
      out += i <= here ? kDigits[group >> (18 - 6 * i) & 63] : '=';
  }
  return out;
}

template <class Value>
std::string packed_of(const std::vector<v1::Point>& points, Value value) {
  std::vector<double> values;
  values.reserve(points.size());
  for (const auto& point : points) values.push_back(static_cast<double>(value(point)));
  return packed(values);
}

Json run_json(const v1::Run& run) {
  const Json all = json_from(run);
  return {{"id", run.id()},
          {"name", run.name()},
          {"state", all["state"]},
          {"reason", run.reason()},
          {"trajectory", run.trajectory_name()},
          {"operator", run.operator_name()},
          {"start", all["start_time"]},
          {"end", all["end_time"]},
          {"rows", run.row_count()},
          {"accepted", run.accepted_count()},
          {"given_up", run.given_up_count()},
          {"attempts", run.attempt_count()},
          {"restarts", run.restart_count()},
          {"compensation", compensation_text(run)}};
}

// What the points measured, channel by channel, in the order in which they first appear.
Json columns_json(const std::vector<v1::Point>& points) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<double>> columns;
  for (std::size_t row = 0; row < points.size(); ++row)
    for (const auto& value : points[row].values()) {
      auto& column = columns[value.channel()];
      if (column.empty()) {
        order.push_back(value.channel());
        column.assign(points.size(), std::numeric_limits<double>::quiet_NaN());
      }
      if (value.has_value()) column[row] = value.value();
    }
  Json out = Json::array();
  for (const auto& channel : order) {
    auto& values = columns[channel];
    double sum = 0;
    std::size_t known = 0;
    for (const double value : values)
      if (std::isfinite(value)) sum += value, ++known;
    const double base = known == 0 ? 0 : sum / static_cast<double>(known);
    const double scale = channel.ends_with("_mm") ? 1e-6 : 1;  // nm from the base
    for (double& value : values) value = (value - base) / scale;
    out.push_back(
        {{"channel", channel}, {"base", base}, {"scale", scale}, {"data", packed(values)}});
  }
  return out;
}

Json points_json(const ReportSource& source) {
  const auto& start = source.run.run().start_time();
  std::map<std::int64_t, int> tries;
  for (const auto& attempt : source.attempts) ++tries[attempt.row()];
  const auto of = [&](auto value) { return packed_of(source.points, value); };
  return {{"count", source.points.size()},
          {"time_s", of([&](const auto& p) { return seconds_between(start, p.measure_time()); })},
          {"row", of([](const auto& p) { return p.row(); })},
          {"line", of([](const auto& p) { return p.line(); })},
          {"set", of([](const auto& p) { return p.set() == v1::POINT_SET_VALIDATION ? 1 : 0; })},
          {"zero", of([](const auto& p) { return p.zero() ? 1 : 0; })},
          {"tries", of([&](const auto& p) { return tries[p.row()]; })},
          {"columns", columns_json(source.points)}};
}

Json attempts_json(const ReportSource& source) {
  Json out = Json::array();
  for (const auto& attempt : source.attempts) {
    if (attempt.verdict() == v1::Attempt::VERDICT_ACCEPTED) continue;
    const Json all = json_from(attempt);
    out.push_back(
        {{"row", attempt.row()},
         {"number", attempt.number()},
         {"verdict", all["verdict"]},
         {"reason", attempt.reason()},
         {"spread_nm", all["spread_nm"]},
         {"time_s", seconds_between(source.run.run().start_time(), attempt.start_time())}});
  }
  return out;
}

// Cell files that it was measured under, oldest first.
Json configurations_json(const v1::Run& run) {
  Json out = Json::array();
  for (const auto& used : run.configurations())
    out.push_back({{"hash", used.hash()},
                   {"from", used.has_from_time() ? Json(iso_text(used.from_time())) : Json()}});
  return out;
}

// In force over its data when the page was made. The points of the page are those of the record, as
// they were measured.
Json corrections_json(const v1::Run& run) {
  Json out = Json::array();
  for (const auto& mark : run.corrections()) {
    Json changes = Json::array();
    for (const auto& change : mark.changes())
      changes.push_back({{"channel", change.channel()},
                         {"rows", change.row_count()},
                         {"largest_nm", change.largest_nm()},
                         {"rms_nm", change.rms_nm()}});
    out.push_back({{"id", mark.correction_id()},
                   {"since", iso_text(mark.accept_time())},
                   {"by", mark.accepted_by()},
                   {"changes", changes}});
  }
  return out;
}

// The numbers among the rules; the page knows max_spread_nm.
Json rules_json(const std::string& text) {
  Json out = Json::object();
  const Json rules = Json::parse(text, nullptr, false);
  if (!rules.is_object()) return out;
  for (const auto& [key, value] : rules.items())
    if (value.is_number()) out[key] = value;
  return out;
}

}  // namespace

std::string packed(const std::vector<double>& values) {
  std::string bytes;
  bytes.reserve(values.size() * 4);
  for (const double value : values) {
    const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
    for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(bits >> shift & 0xff);
  }
  return base64(bytes);
}

namespace {

// The figures only: the rows' errors follow from the points.
Json verification_json(const v1::VerifyRunsResponse& found) {
  const Json all = json_from(found);
  Json out{{"accuracy", all["accuracy"]}};
  for (const char* key : {"row_count", "outside_row_count", "zero_row_count", "outside"})
    out[key] = all["runs"][0][key];
  out["coordinates"] = Json::array();
  for (auto coordinate : all["runs"][0]["coordinates"]) {
    coordinate.erase("errors");
    out["coordinates"].push_back(std::move(coordinate));
  }
  return out;
}

}  // namespace

Json report_json(const ReportSource& source) {
  Json events = Json::array(), axes = Json::array();
  for (const auto& event : source.events)
    events.push_back({{"time", iso_text(event.event_time())},
                      {"who", event.who()},
                      {"what", event.what()},
                      {"detail", event.detail()}});
  for (const auto& device : source.cell.devices())
    for (const auto& axis : device.axes())
      axes.push_back(
          {{"channel", axis.channel()}, {"min_mm", axis.min_mm()}, {"max_mm", axis.max_mm()}});
  Json closures = Json::array();
  for (const auto& one : source.closures)
    closures.push_back({{"line", one.line()},
                        {"repetition", one.repetition()},
                        {"time", iso_text(one.measure_time())},
                        {"decision", json_from(one)["decision"]},
                        {"sentence", one.sentence()}});
  Json certificates = Json::array();
  for (const auto& one : source.certificates.certificates())
    certificates.push_back({{"device", one.device_id()},
                            {"number", one.number()},
                            {"laboratory", one.laboratory()},
                            {"date", one.date()},
                            {"due", one.due_date()},
                            {"overdue", one.has_days_left() && one.days_left() < 0}});
  Json report{{"schema", "driftwise.run-report.v1"},
              {"cell", source.cell.cell_name()},
              {"config_hash", source.run.run().config_hash()},
              {"configurations", configurations_json(source.run.run())},
              {"corrections", corrections_json(source.run.run())},
              {"version", source.version},
              {"made", source.made},
              {"record_head", source.head.entry() > 0 ? Json(head_text(source.head)) : Json()},
              {"run", run_json(source.run.run())},
              {"rules", rules_json(source.run.rules_json())},
              {"points", points_json(source)},
              {"attempts", attempts_json(source)},
              {"closures", closures},
              {"events", events},
              {"axes", axes},
              {"certificates", certificates}};
  if (source.verification && source.verification->runs_size() > 0)
    report["verification"] = verification_json(*source.verification);
  return report;
}

std::string report_page(const std::string& page_template, const Json& data) {
  constexpr std::string_view kOpen = "<script type=\"application/json\" id=\"report-data\">";
  constexpr std::string_view kPlace = "null</script>";
  const std::string wanted = std::string(kOpen) + std::string(kPlace);
  const auto at = page_template.find(wanted);
  if (at == std::string::npos || page_template.find(wanted, at + 1) != std::string::npos)
    throw Failure{ExitCode::bad_input, "invalid_argument", "BAD_TEMPLATE",
                  "the page of reports has not exactly one element for its data: take the "
                  "report.html that was built with this program"};
  std::string text = data.dump(-1, ' ', false, Json::error_handler_t::replace);
  for (std::size_t less = text.find('<'); less != std::string::npos; less = text.find('<', less))
    text.replace(less, 1, "\\u003c");
  std::string page = page_template;
  page.replace(at + kOpen.size(), 4, text);
  return page;
}

}  // namespace driftwise::cli
