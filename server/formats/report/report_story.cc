#include <bit>
#include <cmath>
#include <string_view>

#include "server/formats/report/report_parts.h"

namespace driftwise::formats {
namespace {

using Json = nlohmann::ordered_json;

std::string base64_of_floats(const std::string& bytes) {
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

Json results_json(const RunReport& report, const QueueEntry& entry) {
  Json out = Json::array();
  for (const auto& result : entry.results) {
    const auto position = static_cast<std::size_t>(result.position);
    out.push_back({{"follow_up",
                    position < entry.follow_ups.size() ? Json(entry.follow_ups[position]) : Json()},
                   {"good", result.good},
                   {"text", result.text},
                   {"time", report_time(report, result.at)}});
  }
  return out;
}

Json entry_json(const RunReport& report, std::size_t place) {
  const auto& entry = report.entries[place];
  Json out{{"id", entry.id.value},
           {"name", entry.name},
           {"state", std::string(to_string(entry.state))},
           {"reason", entry.reason},
           {"by", entry.created_by},
           {"queued", report_time(report, entry.created)},
           {"begun", report_time(report, entry.begun)},
           {"ended", report_time(report, entry.ended)},
           {"after", entry.after ? Json(entry.after->value) : Json()},
           {"condition", entry.condition},
           {"run", entry.run ? Json(entry.run->value) : Json()},
           {"results", results_json(report, entry)}};
  if (place < report.runs.size()) {
    const auto& run = report.runs[place];
    out["run_state"] = std::string(to_string(run.state));
    out["rows"] = run.rows;
    out["accepted"] = run.accepted;
    out["given_up"] = run.given_up;
    out["restarts"] = run.restarts;
  }
  return out;
}

Json alarm_json(const RunReport& report, const AlarmRecord& alarm) {
  return {{"id", alarm.id.value},
          {"kind", alarm.kind},
          {"subject", alarm.subject},
          {"priority", std::string(to_string(alarm.priority()))},
          {"state", std::string(to_string(alarm.state()))},
          {"message", alarm.message},
          {"consequences", alarm.consequences},
          {"since", report_time(report, alarm.since)},
          {"over", report_time(report, alarm.cleared)},
          {"acknowledged", report_time(report, alarm.acknowledged)},
          {"acknowledged_by", alarm.acknowledged_by}};
}

Json model_json(const ReportedModel& model) {
  Json accuracy = Json::array(), residuals = Json::array();
  for (const auto& one : model.accuracy) accuracy.push_back(report_judged(one));
  for (const auto& one : model.residuals)
    residuals.push_back({{"output", one.output}, {"unit", one.unit}, {"data", packed(one.values)}});
  std::vector<double> check(model.check.begin(), model.check.end());
  return {{"id", model.id.value}, {"name", model.name},           {"formula", model.formula},
          {"accuracy", accuracy}, {"count", model.time_s.size()}, {"time_s", packed(model.time_s)},
          {"set", packed(check)}, {"residuals", residuals},       {"trouble", model.trouble}};
}

}  // namespace

std::string packed(const std::vector<double>& values) {
  std::string bytes;
  bytes.reserve(values.size() * 4);
  for (const double value : values) {
    const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
    for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(bits >> shift & 0xff);
  }
  return base64_of_floats(bytes);
}

Json report_time(const RunReport& report, CellTime at) {
  return at.utc_ns == 0 ? Json() : Json(to_iso8601(report.utc(at)));
}

Json finite_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json report_figures(const ErrorFigures& figures) {
  return {{"mean", figures.mean},
          {"u90", figures.u90},
          {"a90", figures.a90},
          {"row_count", figures.rows}};
}

Json report_judged(const JudgedAccuracy& judged) {
  return {{"output", judged.output},
          {"unit", judged.unit},
          {"rows", std::string(to_string(judged.rows))},
          {"figures", report_figures(judged.figures)}};
}

void add_story(const RunReport& report, Json& out) {
  if (!report.entries.empty()) {
    Json entries = Json::array();
    for (std::size_t place = 0; place < report.entries.size(); ++place)
      entries.push_back(entry_json(report, place));
    out["queue"] = {{"entry", report.entries.back().id.value}, {"entries", entries}};
  }
  Json alarms = Json::array(), models = Json::array(), diagnoses = Json::array();
  for (const auto& alarm : report.alarms) alarms.push_back(alarm_json(report, alarm));
  for (const auto& model : report.models) models.push_back(model_json(model));
  for (const auto& one : report.diagnoses)
    diagnoses.push_back({{"id", one.id.value},
                         {"state", one.state},
                         {"verdict", one.verdict},
                         {"baseline", one.baseline},
                         {"extended", one.extended},
                         {"findings", one.findings},
                         {"left_over", one.left_over}});
  out["alarms"] = alarms;
  out["models"] = models;
  out["diagnoses"] = diagnoses;
}

}  // namespace driftwise::formats
