#include "clients/cli/fit_commands.h"

#include <memory>

#include "clients/cli/fit_command.h"
#include "clients/cli/input_text.h"
#include "clients/cli/proto_json.h"
#include "clients/cli/validators.h"
#include "driftwise/v1/model_service.grpc.pb.h"
#include "server/formats/fit_json.h"
#include "server/formats/model_json.h"

namespace driftwise::cli {
namespace {

using ModelStub = v1::ModelService::Stub;

struct FitArguments {
  FitOfFile fit;
  std::string file, name, note;
  std::vector<std::int64_t> runs;
};

// What only a file's fit can do: the daemon stores models that can be told in one request.
void refuse_offline_options(const FitOfFile& fit) {
  const auto refuse = [](const std::string& option) {
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  option +
                      " works on a file only: driftwise data export RUN -o data.csv, then "
                      "driftwise fit data.csv"};
  };
  if (!fit.force.empty()) refuse("--force");
  if (!fit.without.empty()) refuse("--without (write \"- term\" in the formula instead)");
  if (!fit.weights.empty()) refuse("--weights");
  if (!fit.exclude_rows.empty()) refuse("--exclude-rows (driftwise data exclude RUN instead)");
  if (fit.criterion != FitOfFile{}.criterion) refuse("--criterion");
  if (fit.hierarchy) refuse("--hierarchy");
  if (fit.starts > 1) refuse("--starts");
  if (!fit.residuals.empty()) refuse("--residuals");
  if (fit.offers) refuse("--offers");
  if (fit.blocks != FitOfFile{}.blocks) refuse("--blocks");
}

v1::CreateFitRequest request_from(const FitArguments& a) {
  v1::CreateFitRequest request;
  for (const std::int64_t run : a.runs) request.add_run_ids(run);
  request.set_formula(a.fit.formula);
  request.set_select(a.fit.select);
  request.set_p_enter(a.fit.p_enter);
  request.set_p_remove(a.fit.p_remove);
  request.set_name(a.name);
  request.set_note(a.note);
  for (const auto& symbol : a.fit.exclude) request.add_exclude_symbols(symbol);
  request.set_first_rows(a.fit.first_rows);
  return request;
}

// Printed as a file's fit is printed: from the stored model itself, every digit of it.
ExitCode fit_at_daemon(const Session& session, const FitArguments& a) {
  refuse_offline_options(a.fit);
  const auto connection = session.connect();
  const auto created = connection.ask(&ModelStub::CreateFit, request_from(a), 300).model();
  v1::ExportModelRequest request;
  request.set_model_id(created.id());
  request.set_format(v1::ExportModelRequest::FORMAT_JSON);
  const auto model =
      formats::read_model_json(connection.ask(&ModelStub::ExportModel, request).text());
  if (!model)
    throw Failure{ExitCode::refused, "data_loss", model.error().reason,
                  "the daemon's model: " + model.error().message};
  if (session.console.json) {
    auto json = formats::fit_json(*model);
    json["model_id"] = created.id();
    session.console.print_json(json);
    return ExitCode::done;
  }
  session.console.out << formats::fit_table(*model, {.history = a.fit.history})
                      << "stored as model " << created.id() << '\n';
  session.console.err << "let it serve with `driftwise model promote " << created.id() << "`\n";
  return ExitCode::done;
}

ExitCode fit(const Session& session, FitArguments& a) {
  if (a.file.empty() == a.runs.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  std::string("fit what? found ") + (a.file.empty() ? "neither" : "both") +
                      " a file and --run; give one: driftwise fit data.csv ..., or driftwise fit "
                      "--run 3 ..."};
  if (a.fit.formula.starts_with('@')) a.fit.formula = read_input_file(a.fit.formula.substr(1));
  if (!a.file.empty()) return fit_file(session.console, a.fit, InputText(a.file).text(), a.file);
  return fit_at_daemon(session, a);
}

}  // namespace

void add_fit_command(CLI::App& app, Session& session) {
  auto a = std::make_shared<FitArguments>();
  CLI::App& command = add_command(
      app, session, "fit",
      "Learns a model from a CSV file (here) or from runs (at the daemon, which stores it)",
      [&session, a] { return fit(session, *a); });
  command.add_option("FILE", a->file, "dataset CSV, - for standard input");
  command.add_option("--run", a->runs, "a run at the daemon instead; repeatable")
      ->allow_extra_args(false)
      ->check(positive_number());
  add_fit_options(command, a->fit);
  command.add_option("--name", a->name, "of the stored model");
  command.add_option("--note", a->note, "kept with the stored model");
}

}  // namespace driftwise::cli
