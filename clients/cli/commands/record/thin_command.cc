#include "clients/cli/commands/record/thin_command.h"

#include <memory>

#include "clients/cli/core/confirm.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/value_or_throw.h"
#include "driftwise/v1/record_service.grpc.pb.h"
#include "server/core/cell_time.h"

namespace driftwise::cli {
namespace {

constexpr double kThinningTakes_s = 24 * 3600;  // a record of years, on a slow disk

struct ThinArguments {
  std::string before, every = "60s", reducer = "mean";
  bool yes = false;
};

CellTime instant_of(const std::string& text) {
  const auto at = parse_iso8601(text.size() == 10 ? text + "T00:00:00Z" : text);
  if (!at)
    throw Failure{ExitCode::usage, "usage", "BAD_TIME",
                  "--before: found '" + text +
                      "', expected a day such as 2026-11-01, or 2026-11-01T12:00:00Z"};
  return *at;
}

// "60s", "10min", "1h", "60".
std::int64_t seconds_of_interval(const std::string& text) {
  std::size_t end = 0;
  std::int64_t number = 0;
  for (; end < text.size() && end < 6 && text[end] >= '0' && text[end] <= '9'; ++end)
    number = 10 * number + (text[end] - '0');
  const std::string unit = text.substr(end);
  const std::int64_t factor = unit.empty() || unit == "s" ? 1
                              : unit == "min"             ? 60
                              : unit == "h"               ? 3600
                                                          : 0;
  if (end == 0 || factor == 0)
    throw Failure{ExitCode::usage, "usage", "BAD_DURATION",
                  "--every: found '" + text + "', expected an interval such as 60s, 10min or 1h"};
  return number * factor;
}

ExitCode thin(const Session& session, const ThinArguments& a) {
  v1::ThinReadingsRequest request;
  const CellTime before = instant_of(a.before);
  request.mutable_before_time()->set_seconds(before.utc_ns / 1'000'000'000);
  request.mutable_every_duration()->set_seconds(seconds_of_interval(a.every));
  request.set_reducer(a.reducer);
  confirm(session.console, a.yes,
          "raw readings of the environment before " + to_iso8601(before) + ":",
          {"are removed; the " + a.reducer + " of every " + a.every + " takes their place",
           "points, and readings near a point, an attempt or a datum, stay"},
          "Thin them");
  const auto done =
      session.connect().ask(&v1::RecordService::Stub::ThinReadings, request, kThinningTakes_s);
  if (session.console.json)
    session.console.print_json(json_from(done));
  else
    session.console.out << done.reading_count() << " readings became " << done.interval_count()
                        << " rows\n";
  return ExitCode::done;
}

}  // namespace

void add_thin_command(CLI::App& app, Session& session) {
  auto a = std::make_shared<ThinArguments>();
  CLI::App& thinning = add_command(
      app, session, "thin",
      "Raw readings of the environment become one row per interval, while the cell works",
      [&session, a] { return thin(session, *a); });
  thinning.add_option("--before", a->before, "a day or an instant, UTC: what is older is thinned")
      ->required();
  thinning.add_option("--every", a->every, "length of an interval: 1s to 1h")->default_str("60s");
  thinning.add_option("--reducer", a->reducer, "what becomes of an interval's values")
      ->default_str("mean")
      ->check(CLI::IsMember({"mean", "min", "max"}));
  thinning.add_flag("--yes", a->yes, "ask nothing: for scripts");
}

}  // namespace driftwise::cli
