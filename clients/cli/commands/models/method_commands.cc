#include "clients/cli/commands/models/method_commands.h"

#include "clients/cli/commands/models/fit_commands.h"
#include "clients/cli/core/session.h"
#include "clients/cli/core/study_stream.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/core/value_or_throw.h"
#include "driftwise/v1/model_service.grpc.pb.h"
#include "server/formats/cell_file/kinematics_section.h"
#include "server/formats/model/method_json.h"
#include "server/identification/accuracy.h"

namespace driftwise::cli {
namespace {

struct Asked {
  RowsOfFile rows;
  identification::MethodOptions options;
  identification::JudgeOptions judge;
};

Asked read_question(const FitOfFile& fit, const MethodsOfFile& methods, std::string_view text,
                    const std::string& name) {
  Asked asked;
  asked.options.fit = fit_options(fit);
  asked.rows = rows_of_file(fit, text, name, asked.options.fit.executor);
  asked.options.fit.lineage.source = name;
  set_terms(fit, asked.rows, asked.options.fit);
  if (!methods.kinematics.empty())
    asked.options.mechanism = value_or_throw(kinematics::make_mechanism(value_or_throw(
        formats::parse_robot_file(read_input_file(methods.kinematics), methods.kinematics))));
  asked.judge.blocks = fit.blocks;
  asked.judge.together = methods.together;
  asked.judge.folds = methods.folds;
  return asked;
}

identification::Judgement judged(const FitOfFile& fit, const Asked& asked,
                                 identification::Method method) {
  auto judgement = value_or_throw(
      identification::judge_method(asked.rows.data, method, asked.options, asked.judge));
  require_validation_rows(fit, judgement.rows_validation);
  return judgement;
}

}  // namespace

void add_method_options(CLI::App& command, MethodsOfFile& methods) {
  command.add_option("--kinematics", methods.kinematics,
                     "robot file or cell.toml with the nominal geometry (docs/kinematics.md)");
  command.add_option("--together", methods.together,
                     "rows that are held out together: line, or channels such as goal_x,goal_y");
  command.add_option("--folds", methods.folds, "of those groups")
      ->check(number_between(2, 1000))
      ->capture_default_str();
}

ExitCode fit_file_by_method(const Console& console, const FitOfFile& fit,
                            const MethodsOfFile& methods, std::string_view text,
                            const std::string& name) {
  refuse_fit_only_options(fit, "fit --method " + methods.methods.front());
  const auto method = identification::method_from(methods.methods.front());
  const auto judgement = judged(fit, read_question(fit, methods, text, name), method.value());
  if (console.json)
    console.print_json(formats::method_json(judgement, fit.formula));
  else
    console.out << formats::method_page(judgement, fit.formula);
  return ExitCode::done;
}

ExitCode compare_methods(const Console& console, const FitOfFile& fit, const MethodsOfFile& methods,
                         std::string_view text, const std::string& name) {
  refuse_fit_only_options(fit, "model compare");
  const Asked asked = read_question(fit, methods, text, name);
  std::vector<identification::Method> chosen;
  for (const auto& one : methods.methods)
    chosen.push_back(identification::method_from(one).value());
  if (chosen.empty())
    chosen =
        identification::methods_possible(!fit.formula.empty(), asked.options.mechanism != nullptr);
  if (chosen.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "compare what? give --model FORMULA, --kinematics robot.toml, or both"};
  std::vector<identification::Judgement> judgements;
  for (const auto method : chosen) judgements.push_back(judged(fit, asked, method));
  if (console.json)
    console.print_json(formats::comparison_json(judgements, fit.formula));
  else
    console.out << formats::comparison_table(judgements);
  return ExitCode::done;
}

ExitCode compare_methods_of_runs(const Session& session, const FitOfFile& fit,
                                 const MethodsOfFile& methods,
                                 const std::vector<std::int64_t>& runs) {
  refuse_fit_only_options(fit, "model compare");
  v1::CompareMethodsRequest request;
  *request.mutable_fit() = fit_request_of(fit, runs);
  for (const auto& method : methods.methods) request.add_methods(method);
  if (!methods.kinematics.empty()) request.set_robot_toml(read_input_file(methods.kinematics));
  request.set_together(methods.together);
  request.set_fold_count(methods.folds);
  const auto answer =
      follow_study(session, &v1::ModelService::Stub::CompareMethods, request, "comparing methods");
  if (session.console.json)
    session.console.print_json(nlohmann::ordered_json::parse(answer.json()));
  else
    session.console.out << answer.table();
  return ExitCode::done;
}

}  // namespace driftwise::cli
