#include "clients/cli/commands/models/formula_commands.h"

#include <memory>

#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/model_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

struct FormulaArguments {
  std::string formula, file, select = "stepwise";
  std::vector<std::int64_t> runs;
  std::vector<std::string> exclude;
};

void print_list(const Console& console, const std::string& what,
                const google::protobuf::RepeatedPtrField<std::string>& names) {
  console.out << what;
  for (const auto& name : names) console.out << ' ' << name;
  console.out << '\n';
}

void print_check(const Console& console, const v1::CheckFormulaResponse& check) {
  const Paint paint = console.paint_out();
  if (!check.problem().empty()) {
    console.out << paint.bad("cannot be fitted: ") << check.problem() << '\n';
  } else {
    console.out << check.canonical() << '\n';
    print_list(console, "outputs:", check.outputs());
    print_list(console, "terms:  ", check.terms());
  }
  console.out << "rows:    " << check.calibration_row_count() << " calibration, "
              << check.validation_row_count() << " validation, " << check.dropped_row_count()
              << " without a value that is needed\n";
  if (check.column_count() > 0)
    console.out << "rank:    " << check.rank() << " of " << check.column_count()
                << " columns, the constant with them\n";
  for (const auto& sentence : check.look_alikes())
    console.out << paint.warn("! ") << sentence << '\n';
  console.out << "channels:";
  for (const auto& channel : check.channels())
    console.out << ' ' << channel.symbol() << '_' << channel.unit();
  console.out << '\n';
}

ExitCode check_formula(const Session& session, const FormulaArguments& a) {
  if (a.file.empty() == a.runs.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  std::string("check it on what? found ") + (a.file.empty() ? "neither" : "both") +
                      " a file and --run; give one"};
  v1::CheckFormulaRequest request;
  auto& fit = *request.mutable_fit();
  for (const std::int64_t run : a.runs) fit.add_run_ids(run);
  if (!a.file.empty()) fit.set_csv(read_input_file(a.file));
  fit.set_formula(a.formula.starts_with('@') ? read_input_file(a.formula.substr(1)) : a.formula);
  for (const auto& symbol : a.exclude) fit.add_exclude_symbols(symbol);
  fit.set_select(a.select);
  const auto check = session.connect().ask(&v1::ModelService::Stub::CheckFormula, request, 60);
  if (session.console.json)
    session.console.print_json(json_from(check));
  else
    print_check(session.console, check);
  return check.problem().empty() ? ExitCode::done : ExitCode::negative;
}

}  // namespace

void add_formula_commands(CLI::App& app, Session& session) {
  CLI::App& formula =
      *app.add_subcommand("formula", "Formulas, before anything is fitted")->require_subcommand(1);
  auto a = std::make_shared<FormulaArguments>();
  CLI::App& check = add_command(
      formula, session, "check",
      "What a formula offers on these data, and what of it they can tell apart; fits nothing",
      [&session, a] { return check_formula(session, *a); });
  check.add_option("FORMULA", a->formula, "\"q ~ poly(x, 3) + T\"; @FILE reads it from a file")
      ->required();
  check.add_option("FILE", a->file, "dataset CSV, - for standard input");
  check.add_option("--run", a->runs, "a run at the daemon instead; repeatable")
      ->allow_extra_args(false)
      ->check(positive_number());
  check.add_option("--select", a->select, "stepwise, or all: the fit that it is for")
      ->check(CLI::IsMember({"stepwise", "all"}))
      ->capture_default_str();
  check
      .add_option("--exclude", a->exclude,
                  "channels whose terms are left out, such as t01,t02; repeatable")
      ->delimiter(',')
      ->allow_extra_args(false);
}

}  // namespace driftwise::cli
