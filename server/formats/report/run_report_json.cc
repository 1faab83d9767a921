#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "server/core/reasons.h"
#include "server/formats/report/report_parts.h"
#include "server/formats/report/run_report.h"

namespace driftwise::formats {
namespace {

using Json = nlohmann::ordered_json;

double seconds_since_start(const RunReport& report, CellTime at) {
  return seconds_from(at - report.run.started);
}

template <class Value>
std::string packed_of(const std::vector<PointRecord>& points, Value value) {
  std::vector<double> values;
  values.reserve(points.size());
  for (const auto& point : points) values.push_back(static_cast<double>(value(point)));
  return packed(values);
}

// Cell time: nobody sets it, as somebody may have set the clock that "start" and "end" are from.
Json elapsed_s_json(const RunRecord& run) {
  if (run.started.utc_ns == 0 || run.ended.utc_ns == 0) return nullptr;
  return seconds_from(run.ended - run.started);
}

Json run_json(const RunReport& report) {
  const auto& run = report.run;
  Json metadata = Json::object();
  for (const auto& item : run.metadata) metadata[item.key] = item.value;
  return {{"id", run.id.value},
          {"name", run.name},
          {"state", std::string(to_string(run.state))},
          {"reason", run.reason},
          {"trajectory", run.trajectory_name},
          {"operator", run.operator_name},
          {"start", report_time(report, run.started)},
          {"end", report_time(report, run.ended)},
          {"elapsed_s", elapsed_s_json(run)},
          {"rows", run.rows},
          {"accepted", run.accepted},
          {"given_up", run.given_up},
          {"attempts", run.attempts},
          {"restarts", run.restarts},
          {"largest_lag_s", run.max_lag_s},
          {"compensation", report.compensation},
          {"metadata", metadata}};
}

// What the points measured, channel by channel, in the order in which they first appear.
Json columns_json(const std::vector<PointRecord>& points) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<double>> columns;
  for (std::size_t row = 0; row < points.size(); ++row)
    for (const auto& value : points[row].values) {
      const auto& name = value.channel;
      auto& column = columns[name];
      if (column.empty()) {
        order.push_back(name);
        column.assign(points.size(), std::numeric_limits<double>::quiet_NaN());
      }
      if (std::isfinite(value.value)) column[row] = value.value;
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

Json points_json(const RunReport& report) {
  std::map<std::int64_t, int> tries;
  for (const auto& attempt : report.attempts) ++tries[attempt.row];
  const auto of = [&](auto value) { return packed_of(report.points, value); };
  return {
      {"count", report.points.size()},
      {"time_s", of([&](const auto& p) { return seconds_since_start(report, p.measured.utc); })},
      {"row", of([](const auto& p) { return p.row + 1; })},
      {"line", of([](const auto& p) { return p.line; })},
      {"set", of([](const auto& p) { return p.set == PointSet::validation ? 1 : 0; })},
      {"zero", of([](const auto& p) { return p.zero ? 1 : 0; })},
      {"tries", of([&](const auto& p) { return tries[p.row]; })},
      {"datum", of([](const auto& p) { return static_cast<double>(p.datum.value); })},
      {"columns", columns_json(report.points)}};
}

Json attempts_json(const RunReport& report) {
  Json out = Json::array();
  for (const auto& attempt : report.attempts) {
    if (attempt.verdict == Verdict::accepted) continue;
    out.push_back({{"row", attempt.row + 1},
                   {"number", attempt.number},
                   {"verdict", std::string(to_string(attempt.verdict))},
                   {"reason", attempt.reason},
                   {"spread_nm", finite_or_null(attempt.spread_nm)},
                   {"time_s", seconds_since_start(report, attempt.started.utc)}});
  }
  return out;
}

// Cell files that it was measured under, oldest first.
Json configurations_json(const RunReport& report) {
  Json out = Json::array();
  for (const auto& used : report.configurations)
    out.push_back({{"hash", used.hash}, {"from", report_time(report, used.from)}});
  return out;
}

// In force over its data when the page was made. The points of the page are those of the record, as
// they were measured.
Json corrections_json(const RunReport& report) {
  Json out = Json::array();
  for (const auto& correction : report.corrections) {
    Json changes = Json::array();
    for (const auto& change : correction.changes)
      changes.push_back({{"channel", change.channel},
                         {"rows", change.rows},
                         {"largest_nm", change.largest_nm},
                         {"rms_nm", change.rms_nm}});
    out.push_back({{"id", correction.id.value},
                   {"since", report_time(report, correction.created)},
                   {"by", correction.created_by},
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

Json certificates_json(const RunReport& report) {
  Json out = Json::array();
  for (const auto& one : report.certificates) {
    const auto days = one.days_left(report.made_utc_ns);
    out.push_back({{"device", one.device},
                   {"number", one.number},
                   {"laboratory", one.laboratory},
                   {"date", one.date},
                   {"due", one.due},
                   {"overdue", days && *days < 0}});
  }
  return out;
}

Json closures_json(const RunReport& report) {
  Json out = Json::array();
  for (const auto& one : report.closures)
    out.push_back({{"line", one.line},
                   {"repetition", one.repetition},
                   {"time", report_time(report, one.measured.utc)},
                   {"decision", std::string(to_string(one.decision))},
                   {"sentence", one.sentence}});
  return out;
}

Json events_json(const RunReport& report) {
  Json out = Json::array();
  for (const auto& event : report.events)
    out.push_back({{"time", report_time(report, event.at.utc)},
                   {"who", event.who},
                   {"what", event.what},
                   {"detail", event.detail},
                   {"run", event.run ? Json(event.run->value) : Json()}});
  return out;
}

Json optional_figures(const std::optional<ErrorFigures>& figures) {
  return figures ? report_figures(*figures) : Json();
}

// The figures only: the rows' errors follow from the points.
Json verification_json(const diagnosis::Verification& found) {
  const auto& run = found.runs.front();
  Json accuracy = Json::array(), coordinates = Json::array();
  for (const auto& one : found.heading) accuracy.push_back(report_judged(one));
  for (const auto& one : run.coordinates)
    coordinates.push_back({{"coordinate", one.channel.symbol},
                           {"unit", one.unit},
                           {"all", report_figures(one.all)},
                           {"inside", report_figures(one.inside)},
                           {"outside", report_figures(one.outside)},
                           {"by_model", optional_figures(one.by_model)},
                           {"largest", one.largest},
                           {"largest_row", one.largest_row + 1}});
  return {{"accuracy", accuracy},
          {"row_count", run.rows},
          {"outside_row_count", run.rows_outside},
          {"zero_row_count", run.rows_zero},
          {"outside", run.outside},
          {"coordinates", coordinates}};
}

}  // namespace

Json run_report_json(const RunReport& report) {
  Json axes = Json::array();
  for (const auto& axis : report.axes)
    axes.push_back(
        {{"channel", axis.channel.name()}, {"min_mm", axis.min_mm}, {"max_mm", axis.max_mm}});
  Json out{{"schema", "driftwise.run-report.v1"},
           {"cell", report.cell},
           {"config_hash", report.run.config_hash},
           {"configurations", configurations_json(report)},
           {"corrections", corrections_json(report)},
           {"version", report.version},
           {"made", report.made},
           {"record_head", report.head.entry > 0 ? Json(to_string(report.head)) : Json()},
           {"run", run_json(report)},
           {"rules", rules_json(report.run.rules_json)},
           {"points", points_json(report)},
           {"attempts", attempts_json(report)},
           {"closures", closures_json(report)},
           {"events", events_json(report)},
           {"axes", axes},
           {"certificates", certificates_json(report)}};
  if (report.verification && !report.verification->runs.empty())
    out["verification"] = verification_json(*report.verification);
  add_story(report, out);
  return out;
}

Result<std::string> report_page(const std::string& page_template, const Json& data) {
  constexpr std::string_view kOpen = "<script type=\"application/json\" id=\"report-data\">";
  constexpr std::string_view kPlace = "null</script>";
  const std::string wanted = std::string(kOpen) + std::string(kPlace);
  const auto at = page_template.find(wanted);
  if (at == std::string::npos || page_template.find(wanted, at + 1) != std::string::npos)
    return fail(ErrorCode::failed_precondition, reasons::kBadText,
                "the page of reports has not exactly one element for its data: install the "
                "report.html that was built with this program");
  std::string text = data.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string page = page_template.substr(0, at + kOpen.size());
  page.reserve(page_template.size() + text.size() + text.size() / 16);
  for (const char c : text)
    if (c == '<')
      page += "\\u003c";
    else
      page += c;
  page += page_template.substr(at + kOpen.size() + 4);
  return page;
}

}  // namespace driftwise::formats
