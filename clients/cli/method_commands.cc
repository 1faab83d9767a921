#include "clients/cli/method_commands.h"

#include "clients/cli/session.h"
#include "clients/cli/value_or_throw.h"
#include "server/formats/dataset_csv.h"
#include "server/formats/formula.h"
#include "server/formats/kinematics_section.h"
#include "server/formats/method_json.h"
#include "server/identification/accuracy.h"

namespace driftwise::cli {
namespace {

struct Asked {
  Dataset data;
  identification::MethodOptions options;
  identification::JudgeOptions judge;
};

Asked read_question(const FitOfFile& fit, const MethodsOfFile& methods, std::string_view text,
                    const std::string& name) {
  Asked asked;
  asked.data = value_or_throw(formats::read_dataset_csv(text, name));
  asked.options.fit = fit_options(fit);
  asked.options.fit.lineage.source = name;
  if (!fit.formula.empty())
    asked.options.fit.candidates =
        value_or_throw(value_or_throw(formats::Formula::parse(fit.formula)).expand(asked.data));
  if (!methods.kinematics.empty())
    asked.options.mechanism = value_or_throw(kinematics::make_mechanism(value_or_throw(
        formats::parse_robot_file(read_input_file(methods.kinematics), methods.kinematics))));
  asked.judge.blocks = fit.blocks;
  asked.judge.together = methods.together;
  asked.judge.folds = methods.folds;
  return asked;
}

identification::Judgement judged(const Asked& asked, identification::Method method) {
  return value_or_throw(
      identification::judge_method(asked.data, method, asked.options, asked.judge));
}

}  // namespace

void add_method_options(CLI::App& command, MethodsOfFile& methods) {
  command.add_option("--kinematics", methods.kinematics,
                     "robot file or cell.toml with the nominal geometry (docs/kinematics.md)");
  command.add_option("--together", methods.together,
                     "rows that are held out together: line, or channels such as goal_x,goal_y");
  command.add_option("--folds", methods.folds, "of those groups")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
}

ExitCode fit_file_by_method(const Console& console, const FitOfFile& fit,
                            const MethodsOfFile& methods, std::string_view text,
                            const std::string& name) {
  const auto method = identification::method_from(methods.methods.front());
  const auto judgement = judged(read_question(fit, methods, text, name), method.value());
  if (console.json)
    console.print_json(formats::method_json(judgement, fit.formula));
  else
    console.out << formats::method_page(judgement, fit.formula);
  return ExitCode::done;
}

ExitCode compare_methods(const Console& console, const FitOfFile& fit, const MethodsOfFile& methods,
                         std::string_view text, const std::string& name) {
  const Asked asked = read_question(fit, methods, text, name);
  std::vector<std::string> names = methods.methods;
  if (names.empty()) {
    const bool formula = !fit.formula.empty(), drawing = asked.options.mechanism != nullptr;
    if (drawing) names.push_back("nominal");
    if (drawing && formula) names.push_back("classic");
    if (drawing) names.push_back("kinematic");
    if (formula) names.push_back("stepwise");
  }
  if (names.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "compare what? give --model FORMULA, --kinematics robot.toml, or both"};
  std::vector<identification::Judgement> judgements;
  for (const auto& one : names)
    judgements.push_back(judged(asked, identification::method_from(one).value()));
  if (!console.json) {
    console.out << formats::comparison_table(judgements);
    return ExitCode::done;
  }
  nlohmann::ordered_json json{{"schema", "driftwise.comparison.v1"}, {"formula", fit.formula}};
  json["methods"] = nlohmann::ordered_json::array();
  for (const auto& judgement : judgements)
    json["methods"].push_back(formats::method_json(judgement, fit.formula));
  console.print_json(json);
  return ExitCode::done;
}

}  // namespace driftwise::cli
