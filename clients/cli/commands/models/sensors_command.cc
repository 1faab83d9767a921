#include "clients/cli/commands/models/sensors_command.h"

#include <cmath>
#include <memory>
#include <set>

#include "clients/cli/commands/models/fit_command.h"
#include "clients/cli/commands/models/fit_commands.h"
#include "clients/cli/core/input_text.h"
#include "clients/cli/core/study_stream.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/core/value_or_throw.h"
#include "driftwise/v1/model_service.grpc.pb.h"
#include "server/calibration/sensor_sets.h"

namespace driftwise::cli {
namespace {

struct SensorsArguments {
  FitOfFile fit;
  std::string file;
  std::vector<std::int64_t> runs;
  double tolerance_pct = 10;
};

std::string listed(const std::vector<std::string>& sensors) {
  std::string text;
  for (const auto& sensor : sensors) text += (text.empty() ? "" : " ") + sensor;
  return text.empty() ? "none" : text;
}

nlohmann::ordered_json study_json(const calibration::SensorStudy& study, const SummaryUnit& unit) {
  nlohmann::ordered_json json{{"schema", "driftwise.sensors.v1"},
                              {"sets_tried", study.sets_tried},
                              {"tolerance", study.tolerance},
                              {"recommended", study.best[study.recommended].sensors}};
  json["sets"] = nlohmann::ordered_json::array();
  for (const auto& set : study.best) {
    nlohmann::ordered_json one{{"count", set.sensors.size()}, {"sensors", set.sensors}};
    one["u90_blocks_rms_" + unit.unit] = set.u90_blocks_rms * unit.factor;
    one["a90_blocks_rms_" + unit.unit] = set.a90_blocks_rms * unit.factor;
    one["cost_" + unit.unit] =
        (set.a90_blocks_rms - study.best.front().a90_blocks_rms) * unit.factor;
    for (const auto& figure : set.outputs) {
      auto& output = one["outputs"][figure.output];
      output["u90_blocks_" + unit.unit] = figure.u90_blocks * unit.factor;
      output["mean_blocks_" + unit.unit] = figure.mean_blocks * unit.factor;
      output["a90_blocks_" + unit.unit] = figure.a90_blocks * unit.factor;
      const auto put = [&](const char* key, const std::optional<double>& value) {
        if (value) output[key + unit.unit] = *value * unit.factor;
      };
      put("u90_validation_", figure.u90_validation);
      put("mean_validation_", figure.mean_validation);
      put("a90_validation_", figure.a90_validation);
    }
    json["sets"].push_back(std::move(one));
  }
  return json;
}

void print_study(const Console& console, const calibration::SensorStudy& study,
                 const SummaryUnit& unit) {
  std::vector<Table::Column> columns = {
      {"thermometers", Align::right}, {"A90 " + unit.unit, Align::right}, {"cost", Align::right}};
  for (const auto& figure : study.best.front().outputs) {
    columns.push_back({figure.output, Align::right});
    if (figure.a90_validation) columns.push_back({"(validation)", Align::right});
  }
  columns.push_back({"the best set"});
  Table table(columns);
  for (std::size_t i = 0; i < study.best.size(); ++i) {
    const auto& set = study.best[i];
    const double cost = (set.a90_blocks_rms - study.best.front().a90_blocks_rms) * unit.factor;
    std::vector<Table::Cell> row = {std::to_string(set.sensors.size()),
                                    fixed(set.a90_blocks_rms * unit.factor, 1),
                                    (cost < 0 ? "" : "+") + fixed(cost, 1)};
    for (const auto& figure : set.outputs) {
      row.push_back(fixed(figure.a90_blocks * unit.factor, 1));
      if (figure.a90_validation) row.push_back(fixed(*figure.a90_validation * unit.factor, 1));
    }
    row.push_back(listed(set.sensors) + (i == study.recommended ? "   <- suffices" : ""));
    table.add(row);
  }
  console.out << "Which thermometers suffice: the best of all " << study.sets_tried
              << " sets for each number of them, by A90 held out by blocks of time\n\n";
  table.print(console.out, console.paint_out());
  console.out << "\nsuffices: the fewest within " << fixed(100 * study.tolerance, 0)
              << " % of the best, on the validation rows as well where there are any: they rank "
                 "nothing, they can only say no.\nThe best of many sets looks a little better than "
                 "it is.\n";
}

ExitCode show_study(const Console& console, const calibration::SensorStudy& found,
                    const SummaryUnit& unit) {
  if (console.json)
    console.print_json(study_json(found, unit));
  else
    print_study(console, found, unit);
  return ExitCode::done;
}

ExitCode study_file(const Console& console, const SensorsArguments& a) {
  auto options = fit_options(a.fit);
  const auto rows = rows_of_file(a.fit, InputText(a.file).text(), a.file, options.executor);
  const Dataset& data = rows.data;
  options.stopwatch_us = {};
  set_terms(a.fit, rows, options);
  const auto found =
      value_or_throw(calibration::study_sensors(data, options, a.tolerance_pct / 100));
  const auto* output = data.find(found.best.front().outputs.front().output);
  return show_study(console, found, summary_unit(output->channel.unit));
}

// The daemon's figures are in the summary's unit already.
calibration::SensorStudy study_from(const v1::StudySensorsResponse& answer) {
  calibration::SensorStudy study;
  for (const auto& set : answer.best()) {
    auto& one = study.best.emplace_back();
    one.sensors.assign(set.sensors().begin(), set.sensors().end());
    for (const auto& output : set.outputs()) {
      auto& figure = one.outputs.emplace_back();
      figure.output = output.output();
      figure.u90_blocks = output.u90_blocks();
      figure.mean_blocks = output.mean_blocks();
      figure.a90_blocks = output.a90_blocks();
      if (output.has_u90_validation()) figure.u90_validation = output.u90_validation();
      if (output.has_mean_validation()) figure.mean_validation = output.mean_validation();
      if (output.has_a90_validation()) figure.a90_validation = output.a90_validation();
    }
    one.u90_blocks_rms = set.u90_blocks_rms();
    one.a90_blocks_rms = set.a90_blocks_rms();
    if (set.has_a90_validation_rms()) one.a90_validation_rms = set.a90_validation_rms();
    if (set.has_u90_validation_rms()) one.u90_validation_rms = set.u90_validation_rms();
  }
  study.recommended = static_cast<std::size_t>(answer.recommended());
  study.sets_tried = static_cast<std::size_t>(answer.tried_set_count());
  study.tolerance = answer.tolerance();
  return study;
}

ExitCode study_runs(const Session& session, const SensorsArguments& a) {
  v1::StudySensorsRequest request;
  *request.mutable_fit() = fit_request_of(a.fit, a.runs);
  request.set_tolerance(a.tolerance_pct / 100);
  const auto answer = follow_study(session, &v1::ModelService::Stub::StudySensors, request,
                                   "choosing thermometers");
  const auto study = study_from(answer);
  if (study.recommended >= study.best.size())
    throw Failure{ExitCode::refused, "internal", "BUG", "the daemon answered with no set at all"};
  return show_study(session.console, study, {answer.unit(), 1});
}

ExitCode study(const Session& session, const SensorsArguments& a) {
  if (a.file.empty() == a.runs.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  std::string("which sensors of what? found ") +
                      (a.file.empty() ? "neither" : "both") + " a file and --run; give one"};
  if (a.fit.formula.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE", "--model is required: a formula with T in it"};
  refuse_fit_only_options(a.fit, "model sensors");
  return a.file.empty() ? study_runs(session, a) : study_file(session.console, a);
}

}  // namespace

void add_sensors_command(CLI::App& model, Session& session) {
  auto a = std::make_shared<SensorsArguments>();
  CLI::App& command = add_command(model, session, "sensors",
                                  "Which thermometers suffice, and what each fewer costs",
                                  [&session, a] { return study(session, *a); });
  command.add_option("FILE", a->file, "dataset CSV, - for standard input");
  command.add_option("--run", a->runs, "a run at the daemon instead; repeatable")
      ->allow_extra_args(false)
      ->check(positive_number());
  add_fit_options(command, a->fit);
  command
      .add_option("--tolerance", a->tolerance_pct,
                  "percent of the best A90 that fewer thermometers may cost")
      ->check(number_between(0.0, 1000.0))
      ->capture_default_str();
}

}  // namespace driftwise::cli
