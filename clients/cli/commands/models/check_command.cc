#include "clients/cli/commands/models/check_command.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/model_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using ModelStub = v1::ModelService::Stub;

struct CheckArguments {
  std::int64_t model = 0;
  std::vector<std::int64_t> runs;
};

std::string with_limit(bool known, double value, double limit, const std::string& sign) {
  return known ? signed_fixed(value, 1) + " (" + sign + fixed(limit, 1) + ")" : "-";
}

void print_output(const Console& console, const v1::OutputCheck& output) {
  const Paint paint = console.paint_out();
  console.out << '\n'
              << paint.bold(output.channel()) << "  reference sd "
              << fixed(output.reference_sd(), 1) << ' ' << output.unit() << " ("
              << output.reference_source() << ", " << fixed(output.reference_dof(), 0)
              << " degrees of freedom), autocorrelation " << fixed(output.lag1_autocorrelation(), 2)
              << '\n';
  Table table({{"run", Align::right},
               {"started (UTC)"},
               {"rows", Align::right},
               {"bias " + output.unit() + " (limit)", Align::right},
               {"bias within its limits"},
               {"sd " + output.unit() + " (limit)", Align::right},
               {"A90 " + output.unit(), Align::right},
               {"EWMA bias (limit)", Align::right},
               {""}});
  for (const auto& run : output.runs()) {
    const std::string started = run.has_start_time() ? clock_text(run.start_time()) : "-";
    if (!run.judged()) {
      table.add({std::to_string(run.run_id()), started, std::to_string(run.row_count()), "", "", "",
                 "", "", "not judged: " + run.why_not()});
      continue;
    }
    table.add({std::to_string(run.run_id()),
               started,
               std::to_string(run.row_count()),
               with_limit(run.has_bias_limit(), run.bias(), run.bias_limit(), "+-"),
               run.has_bias_limit() ? chart_line(run.bias(), run.bias_limit()) : "zero not known",
               fixed(run.sd(), 1) + " (" + fixed(run.sd_limit(), 1) + ")",
               fixed(run.a90(), 1),
               with_limit(run.has_ewma_bias(), run.ewma_bias(), run.ewma_bias_limit(), "+-"),
               {run.out_of_control().empty() ? "" : "out of control", Colour::bad}});
  }
  table.print(console.out, paint);
}

ExitCode check(const Session& session, const CheckArguments& a) {
  v1::CheckModelRequest request;
  request.set_model_id(a.model);
  for (const std::int64_t run : a.runs) request.add_run_ids(run);
  const auto response = session.connect().ask(&ModelStub::CheckModel, request, 120);
  const bool negative = response.verdict() == v1::CheckModelResponse::VERDICT_RECALIBRATE;
  const bool good = response.verdict() == v1::CheckModelResponse::VERDICT_IN_CONTROL;
  // A script must not take "nothing was judged" for "in control".
  const ExitCode exit = negative ? ExitCode::negative : good ? ExitCode::done : ExitCode::refused;
  const Console& console = session.console;
  if (console.json) {
    console.print_json(json_from(response));
    return exit;
  }
  const Paint paint = console.paint_out();
  console.out << "model " << response.model_id() << ": ";
  if (negative)
    console.out << paint.bad("recalibrate now") << '\n';
  else if (good)
    console.out << paint.good("in control") << ": the robot still does what the model says\n";
  else
    console.out << "not judged: no run since it was made has enough points\n";
  for (const auto& reason : response.reasons()) console.out << "  " << reason << '\n';
  for (const auto& output : response.outputs())
    if (!output.runs().empty()) print_output(console, output);
  return exit;
}

}  // namespace

std::string chart_line(double value, double limit) {
  constexpr int kHalf = 10;
  std::string line(2 * kHalf + 1, '.');
  line[kHalf] = '+';
  const double place = limit > 0 && std::isfinite(value) ? value / limit * kHalf : 0;
  const int at = static_cast<int>(std::lround(std::clamp(place, -1.0 * kHalf, 1.0 * kHalf)));
  line[static_cast<std::size_t>(kHalf + at)] = std::abs(value) > limit ? 'X' : 'o';
  return "|" + line + "|";
}

void add_check_command(CLI::App& model, Session& session) {
  auto a = std::make_shared<CheckArguments>();
  CLI::App& command =
      add_command(model, session, "check",
                  "Does the robot still do what the model says? Exit code 1: recalibrate now; 5: "
                  "nothing was judged",
                  [&session, a] { return check(session, *a); });
  command.add_option("MODEL", a->model, "number of the model; else the one that serves")
      ->check(positive_number());
  command.add_option("--runs", a->runs, "these runs, such as 3,4; else every one since")
      ->delimiter(',')
      ->check(positive_number());
}

}  // namespace driftwise::cli
