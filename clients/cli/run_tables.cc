#include "clients/cli/run_tables.h"

#include "clients/cli/proto_json.h"
#include "clients/cli/table.h"
#include "clients/cli/text.h"
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
  std::vector<Table::Column> columns = {
      {"row", Align::right}, {"set"}, {"line", Align::right}, {"measured (UTC)"}};
  if (all.points_size() > 0)
    for (const auto& value : all.points(0).values())
      columns.push_back({value.channel(), Align::right});
  Table table(columns);
  for (const auto& point : all.points()) {
    std::vector<std::string> row = {
        std::to_string(point.row()),
        point.set() == v1::POINT_SET_VALIDATION ? "validation" : "calibration",
        std::to_string(point.line()), clock_text(point.measure_time())};
    for (const auto& value : point.values()) row.push_back(value_text(value));
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

ExitCode show_datums(const Session& session, std::int64_t run_id) {
  v1::ListDatumsRequest request;
  request.set_run_id(run_id);
  const auto response = session.connect().ask(&RunStub::ListDatums, request);
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  Table table({{"datum", Align::right}, {"opened (UTC)"}, {"reason"}, {"conditions"}});
  for (const auto& datum : response.datums()) {
    std::string conditions;
    for (const auto& value : datum.values())
      conditions += value.channel() + "=" + value_text(value) + " ";
    table.add(
        {std::to_string(datum.id()), clock_text(datum.open_time()), datum.reason(), conditions});
  }
  table.print(session.console.out, session.console.paint_out());
  return ExitCode::done;
}

}  // namespace driftwise::cli
