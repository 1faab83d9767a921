#include "clients/cli/commands/runs/run_tables.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "driftwise/v1/run_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using RunStub = v1::RunService::Stub;
constexpr int kPage = 1000;

std::string value_text(const v1::ChannelValue& value) {
  if (!value.has_value()) return "-";
  const std::string& name = value.channel();
  const int decimals = name.ends_with("_mm")   ? 6
                       : name.ends_with("_nm") ? 1
                                               : 4;  // 1 nm, 0.1 nm, 0.1 mK
  return fixed(value.value(), decimals);
}

// Motor coordinates, then pose, then what else was measured: what a person looks for stands first.
int place_of(const std::string& channel) {
  const bool cut = channel.find("_cmd_") != std::string::npos;
  if (channel.size() > 1 && channel[0] == 'q' && channel[1] >= '0' && channel[1] <= '9')
    return cut ? 1 : 0;
  static const std::set<std::string> pose = {"x_mm",      "y_mm",      "z_mm",
                                             "rx_arcsec", "ry_arcsec", "rz_arcsec"};
  if (pose.contains(channel)) return 2;
  return channel == "force_N" ? 3 : 4;
}

// Of all points: one that lacks a value does not move the others' under wrong headers.
std::vector<std::string> channels_of(const v1::ListPointsResponse& all) {
  std::vector<std::string> channels;
  std::set<std::string> known;
  for (const auto& point : all.points())
    for (const auto& value : point.values())
      if (known.insert(value.channel()).second) channels.push_back(value.channel());
  std::ranges::stable_sort(channels, {}, place_of);
  return channels;
}

std::string verdict_text(v1::Attempt::Verdict verdict) {
  std::string text = v1::Attempt::Verdict_Name(verdict).substr(std::string_view("VERDICT_").size());
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

ExitCode show_points(const Session& session, std::int64_t run_id) {
  const auto connection = session.connect();
  v1::ListPointsRequest request;
  request.set_run_id(run_id);
  request.set_limit(kPage);
  v1::ListPointsResponse all;
  while (true) {
    const auto page = connection.ask(&RunStub::ListPoints, request);
    all.MergeFrom(page);
    if (page.points_size() < kPage) break;
    request.set_after_point_id(page.points(page.points_size() - 1).id());
  }
  if (session.console.json) {
    session.console.print_json(json_from(all));
    return ExitCode::done;
  }
  const auto channels = channels_of(all);
  std::vector<Table::Column> columns = {
      {"row", Align::right}, {"set"}, {"line", Align::right}, {"measured (UTC)"}};
  for (const auto& channel : channels) columns.push_back({channel, Align::right});
  Table table(columns);
  for (const auto& point : all.points()) {
    std::vector<Table::Cell> row = {
        point.passage() ? "-" : std::to_string(point.row()),
        std::string(point.passage()                           ? "passage"
                    : point.set() == v1::POINT_SET_VALIDATION ? "validation"
                                                              : "calibration") +
            (point.repeated_line() ? ", repeated" : ""),
        std::to_string(point.line()), clock_text(point.measure_time())};
    for (const auto& channel : channels) {
      const auto value = std::ranges::find(point.values(), channel, &v1::ChannelValue::channel);
      row.push_back(value == point.values().end() ? "-" : value_text(*value));
    }
    table.add(std::move(row));
  }
  table.print(session.console.out, session.console.paint_out());
  return ExitCode::done;
}

ExitCode show_attempts(const Session& session, std::int64_t run_id) {
  v1::ListAttemptsRequest request;
  request.set_run_id(run_id);
  const auto response = session.connect().ask(&RunStub::ListAttempts, request);
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  Table table({{"row", Align::right},
               {"try", Align::right},
               {"verdict"},
               {"spread nm", Align::right},
               {"started (UTC)"},
               {"reason"}});
  for (const auto& attempt : response.attempts())
    table.add({std::to_string(attempt.row()), std::to_string(attempt.number()),
               verdict_text(attempt.verdict()),
               attempt.has_spread_nm() ? fixed(attempt.spread_nm(), 1) : "-",
               clock_text(attempt.start_time()), attempt.reason()});
  table.print(session.console.out, session.console.paint_out());
  return ExitCode::done;
}

std::string decision_text(v1::Closure::Decision decision) {
  switch (decision) {
    case v1::Closure::DECISION_WITHIN:
      return "within the limit";
    case v1::Closure::DECISION_EXPLAINED:
      return "explained";
    case v1::Closure::DECISION_PLAY:
      return "play";
    case v1::Closure::DECISION_MARKED:
      return "line suspect";
    case v1::Closure::DECISION_REPEATED:
      return "line repeated";
    case v1::Closure::DECISION_NEW_DATUM:
      return "new datum";
    default:
      return "-";
  }
}

v1::ListClosuresResponse closures_of_run(const Connection& connection, std::int64_t run_id) {
  v1::ListClosuresRequest request;
  request.set_run_id(run_id);
  return connection.ask(&RunStub::ListClosures, request);
}

void print_closure_summary(const Console& console, const v1::ListClosuresResponse& closures) {
  if (closures.closures().empty()) return;
  std::map<v1::Closure::Decision, int> counts;
  for (const auto& closure : closures.closures()) ++counts[closure.decision()];
  std::string text;
  for (const auto& [decision, count] : counts)
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + decision_text(decision);
  console.out << "returns to zero: " << text << '\n';
  for (const auto& closure : closures.closures())
    if (closure.decision() != v1::Closure::DECISION_WITHIN)
      console.out << "  " << utc_text(closure.measure_time()) << " line " << closure.line() << ": "
                  << closure.sentence() << '\n';
}

namespace {

void print_closures(const Session& session, const v1::ListClosuresResponse& closures) {
  Table table({{"line", Align::right},
               {"measured (UTC)"},
               {"coordinate"},
               {"found", Align::right},
               {"limit", Align::right},
               {"expected", Align::right},
               {"play", Align::right},
               {"noise u", Align::right},
               {"unit"},
               {"from"},
               {"verdict"}});
  for (const auto& closure : closures.closures())
    for (const auto& one : closure.coordinates()) {
      const int decimals = one.unit() == "nm" ? 0 : 2;
      table.add({std::to_string(closure.line()) + (closure.repetition() > 0 ? ", again" : ""),
                 clock_text(closure.measure_time()), one.channel(),
                 signed_fixed(one.found(), decimals), fixed(one.limit(), decimals),
                 signed_fixed(one.expected(), decimals), signed_fixed(one.play(), decimals),
                 fixed(one.noise(), decimals + 1), one.unit(), closure.side(),
                 decision_text(closure.decision())});
    }
  session.console.out << '\n';
  table.print(session.console.out, session.console.paint_out());
}

}  // namespace

ExitCode show_datums(const Session& session, std::int64_t run_id) {
  v1::ListDatumsRequest request;
  request.set_run_id(run_id);
  const auto connection = session.connect();
  const auto response = connection.ask(&RunStub::ListDatums, request);
  const auto closures = closures_of_run(connection, run_id);
  if (session.console.json) {
    auto json = json_from(response);
    json.update(json_from(closures));
    session.console.print_json(json);
    return ExitCode::done;
  }
  Table table({{"datum", Align::right}, {"opened (UTC)"}, {"reason"}, {"conditions"}});
  constexpr int kAtOnce = 4;  // a line of a terminal each
  for (const auto& datum : response.datums()) {
    std::vector<Table::Cell> row = {std::to_string(datum.id()), clock_text(datum.open_time()),
                                    datum.reason()};
    std::string conditions;
    for (int i = 0; i < datum.values_size(); ++i) {
      conditions += datum.values(i).channel() + "=" + value_text(datum.values(i)) + " ";
      if ((i + 1) % kAtOnce != 0 && i + 1 < datum.values_size()) continue;
      row.push_back(conditions);
      table.add(std::move(row));
      row = {"", "", ""};
      conditions.clear();
    }
    if (datum.values_size() == 0) table.add(std::move(row));
  }
  table.print(session.console.out, session.console.paint_out());
  if (!closures.closures().empty()) print_closures(session, closures);
  return ExitCode::done;
}

}  // namespace driftwise::cli
