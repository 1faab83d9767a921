#include "clients/cli/commands/runs/verify_command.h"

#include <memory>

#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/pages/accuracy_line.h"
#include "clients/cli/pages/run_text.h"
#include "driftwise/v1/run_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

struct VerifyArguments {
  std::vector<std::int64_t> runs;
  std::int64_t model = 0;
};

void add_figures(Table& table, const v1::VerifiedCoordinate& of, const std::string& points,
                 const v1::ErrorFigures& figures) {
  if (figures.row_count() == 0) return;
  table.add({of.coordinate() + " (" + of.unit() + ")", points, std::to_string(figures.row_count()),
             fixed(figures.a90(), 1), signed_fixed(figures.mean(), 1), fixed(figures.u90(), 1)});
}

void print_verified(const Console& console, const v1::VerifiedRun& verified) {
  const auto& run = verified.run();
  console.out << '\n'
              << console.paint_out().bold("run " + std::to_string(run.id())) << "  " << run.name()
              << ", " << compensation_text(run) << ": " << verified.row_count() << " points";
  if (verified.zero_row_count() > 0)
    console.out << ", " << verified.zero_row_count() << " returns to zero left out";
  console.out << '\n';
  if (!verified.outside().empty()) {
    console.out << "outside the model's range: " << verified.outside_row_count() << " points (";
    for (int i = 0; i < verified.outside_size(); ++i)
      console.out << (i == 0 ? "" : ", ") << verified.outside(i);
    console.out << ")\n";
  }
  Table table({{"target minus measured"},
               {"points"},
               {"count", Align::right},
               {"A90", Align::right},
               {"mean", Align::right},
               {"S90", Align::right}});
  for (const auto& one : verified.coordinates()) {
    add_figures(table, one, "all", one.all());
    if (one.outside().row_count() > 0) {
      add_figures(table, one, "inside the range", one.inside());
      add_figures(table, one, "outside", one.outside());
    }
    if (one.has_by_model()) add_figures(table, one, "all, axes' own misses out", one.by_model());
  }
  table.print(console.out, console.paint_out());
  for (const auto& one : verified.coordinates())
    console.out << "largest of " << one.coordinate() << ": " << signed_fixed(one.largest(), 1)
                << ' ' << one.unit() << " in row " << one.largest_row() << " of run "
                << verified.run().id() << '\n';
}

void print_change(const Console& console, const v1::VerifiedChange& change) {
  console.out << "\nrun " << change.run_id() << " against run " << change.against_run_id() << ", "
              << (change.position_count() > 0
                      ? "on the " + std::to_string(change.position_count()) +
                            " positions that both visited"
                      : std::string("no position in common: all points of each"))
              << '\n';
  Table table({{"coordinate"},
               {"A90 run " + std::to_string(change.against_run_id()), Align::right},
               {"run " + std::to_string(change.run_id()), Align::right},
               {"mean", Align::right},
               {"", Align::right},
               {"S90", Align::right},
               {"", Align::right}});
  for (const auto& one : change.coordinates()) {
    if (!one.has_before()) continue;
    table.add({one.output() + " (" + one.unit() + ")", fixed(one.before().a90(), 1),
               fixed(one.figures().a90(), 1), signed_fixed(one.before().mean(), 1),
               signed_fixed(one.figures().mean(), 1), fixed(one.before().u90(), 1),
               fixed(one.figures().u90(), 1)});
  }
  table.print(console.out, console.paint_out());
}

ExitCode verify(const Session& session, const VerifyArguments& a) {
  v1::VerifyRunsRequest request;
  for (const std::int64_t run : a.runs) request.add_run_ids(run);
  if (a.model != 0) request.set_model_id(a.model);
  const auto response = session.connect().ask(&v1::RunService::Stub::VerifyRuns, request, 120);
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  for (const auto& one : response.accuracy())
    session.console.out << "accuracy (A90) of run " << response.runs(0).run().id() << ": "
                        << accuracy_text(one) << '\n';
  for (const auto& run : response.runs()) print_verified(session.console, run);
  for (const auto& change : response.changes()) print_change(session.console, change);
  return ExitCode::done;
}

}  // namespace

void add_verify_command(CLI::App& run, Session& session) {
  auto a = std::make_shared<VerifyArguments>();
  CLI::App& command = add_command(
      run, session, "verify", "What compensation achieved: target minus measured, per coordinate",
      [&session, a] { return verify(session, *a); });
  command.add_option("RUN", a->runs, "a run of wanted poses, then others to compare it with")
      ->required()
      ->check(positive_number());
  command
      .add_option("--model", a->model,
                  "whose range says inside and outside; else the run's own model")
      ->check(positive_number());
}

}  // namespace driftwise::cli
