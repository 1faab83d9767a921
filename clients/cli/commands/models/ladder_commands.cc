#include "clients/cli/commands/models/ladder_commands.h"

#include <algorithm>
#include <memory>
#include <set>

#include "clients/cli/commands/data/exported_csv.h"
#include "clients/cli/commands/models/fit_command.h"
#include "clients/cli/core/input_text.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/core/value_or_throw.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/csv/set_names.h"
#include "server/formats/formula/formula.h"
#include "server/formats/text/text.h"
#include "server/identification/ladder.h"
#include "server/identification/learning_curve.h"
#include "server/identification/set_table.h"
#include "server/threads/threaded_executor.h"

namespace driftwise::cli {
namespace {

using nlohmann::ordered_json;

struct StudyArguments {
  std::string file;
  std::vector<std::int64_t> runs;
  FitOfFile fit;  // of points: the formula and how its terms are chosen
  std::vector<std::string> outputs, models, sets;
  std::string together;
  int folds = 10, most_order = 5, threads = 0, sizes = 8, draws = 5;
  std::int64_t seed = 1;
  double least_gain_pct = 1;
};

// A dataset and the words of its column `set`.
struct NamedRows {
  Dataset data;
  std::vector<std::string> words;
};

NamedRows rows_of(const Session& session, const StudyArguments& a,
                  const calibration::Executor& executor) {
  if (a.file.empty() == a.runs.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  std::string("of which data? found ") + (a.file.empty() ? "neither" : "both") +
                      " a file and --run; give one"};
  const auto read = [&](std::string_view text, const std::string& name) {
    return NamedRows{value_or_throw(formats::read_dataset_csv(text, name, executor)),
                     value_or_throw(formats::read_set_names(text, name))};
  };
  if (a.file.empty()) return read(exported_csv(session, a.runs, false), "runs");
  const InputText input(a.file);
  return read(input.text(), a.file);
}

Dataset dataset_of(const Session& session, const StudyArguments& a,
                   const calibration::Executor& executor) {
  return rows_of(session, a, executor).data;
}

[[noreturn]] void refuse_set(const std::string& name, const std::vector<std::string>& named) {
  std::vector<std::string_view> known{"validation"};
  known.insert(known.end(), named.begin(), named.end());
  const auto nearest = formats::nearest_word(name, known);
  std::string list;
  for (const auto one : known) list += (list.empty() ? "" : ", ") + std::string(one);
  throw Failure{ExitCode::bad_input, "invalid_argument", reasons::kBadSet,
                "--set " + name + ": the data name no such set" +
                    (nearest.empty() ? "" : ", did you mean " + nearest + "?") +
                    "; expected one of " + list + ", or ranges of channels: --set '" + name +
                    ": t07 21..23'"};
}

// Those of --set. A name without ranges means the rows of that name; "validation", where the data
// have no such name of their own, every validation row. None given: every validation row, then each
// set that the data name.
std::vector<identification::NamedSet> sets_of(const std::vector<std::string>& texts,
                                              const std::vector<std::string>& words) {
  const auto named = formats::named_sets(words);
  std::vector<identification::NamedSet> sets;
  for (const auto& text : texts) {
    auto set = value_or_throw(identification::named_set_from(text));
    const bool known = std::ranges::find(named, set.name) != named.end();
    if (!known && set.conditions.empty() && set.name != "validation") refuse_set(set.name, named);
    if (known) set.word = set.name;
    sets.push_back(std::move(set));
  }
  if (!sets.empty()) return sets;
  sets.push_back({.name = "validation", .conditions = {}});
  for (const auto& name : named) sets.push_back({.name = name, .conditions = {}, .word = name});
  return sets;
}

calibration::Executor executor_of(int threads) {
  return threads::threaded_executor(threads == 0 ? threads::processors() : threads);
}

// "q", every motor coordinate, unless named.
std::vector<std::string> outputs_of(const Dataset& data, const std::vector<std::string>& named) {
  if (!named.empty()) return named;
  std::vector<std::string> outputs;
  std::set<std::string_view> robots;
  for (const auto& column : data.columns) {
    const std::string& symbol = column.channel.symbol;
    if (!is_motor_symbol(without_robot(symbol))) continue;
    outputs.push_back(symbol);
    robots.insert(robot_of(symbol));
  }
  if (robots.size() > 1)
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "the data have motor coordinates of " + std::to_string(robots.size()) +
                      " robots: name those of one, for example --output " + outputs.front()};
  return outputs;
}

std::string percent(double share) { return fixed(100 * share, 1) + " %"; }

ordered_json ladder_json(const identification::Ladder& ladder) {
  ordered_json json{{"schema", "driftwise.ladder.v1"}, {"formula", ladder.formula()},
                    {"stopped", ladder.stopped},       {"held_out", ladder.held_out},
                    {"rows_calibration", ladder.rows}, {"notes", ladder.notes}};
  const SummaryUnit unit = summary_unit(ladder.steps.front().outputs.front().output.unit);
  json["steps"] = ordered_json::array();
  for (const auto& step : ladder.steps) {
    ordered_json one{{"added", step.added}, {"formula", step.formula}, {"terms", step.terms}};
    one["a90_rms_" + unit.unit] = step.a90_rms * unit.factor;
    one["gain"] = step.gain;
    one["gain_u"] = step.gain_u;
    for (const auto& figure : step.outputs) {
      auto& output = one["outputs"][figure.output.symbol];
      output["a90_" + unit.unit] = figure.a90 * unit.factor;
      output["a90_ci90_" + unit.unit] = {figure.low * unit.factor, figure.high * unit.factor};
      if (figure.a90_validation)
        output["a90_validation_" + unit.unit] = *figure.a90_validation * unit.factor;
    }
    json["steps"].push_back(std::move(one));
  }
  json["refused"] = ordered_json::array();
  for (const auto& trial : ladder.refused) {
    ordered_json one{{"terms", trial.name}};
    if (trial.why_not.empty()) {
      one["a90_rms_" + unit.unit] = trial.a90_rms * unit.factor;
      one["gain"] = trial.gain;
      one["gain_u"] = trial.gain_u;
    } else {
      one["why_not"] = trial.why_not;
    }
    json["refused"].push_back(std::move(one));
  }
  return json;
}

void print_ladder(const Console& console, const identification::Ladder& ladder) {
  const SummaryUnit unit = summary_unit(ladder.steps.front().outputs.front().output.unit);
  std::vector<Table::Column> columns{{"step", Align::right},   {"added"},
                                     {"terms", Align::right},  {"A90 " + unit.unit, Align::right},
                                     {"gained", Align::right}, {"+-", Align::right}};
  for (const auto& figure : ladder.steps.front().outputs) {
    columns.push_back({figure.output.symbol, Align::right});
    if (figure.a90_validation) columns.push_back({"(validation)", Align::right});
  }
  Table table(columns);
  for (std::size_t i = 0; i < ladder.steps.size(); ++i) {
    const auto& step = ladder.steps[i];
    std::vector<Table::Cell> row{std::to_string(i),
                                 step.added,
                                 std::to_string(step.terms),
                                 fixed(step.a90_rms * unit.factor, 1),
                                 i == 0 ? "" : percent(step.gain),
                                 i == 0 ? "" : percent(step.gain_u)};
    for (const auto& figure : step.outputs) {
      row.push_back(fixed(figure.a90 * unit.factor, 1));
      if (figure.a90_validation) row.push_back(fixed(*figure.a90_validation * unit.factor, 1));
    }
    table.add(row);
  }
  console.out << "Ladder of terms on " << ladder.rows << " calibration rows, judged by "
              << ladder.held_out << " held out; validation rows are shown and not asked\n\n";
  table.print(console.out, console.paint_out());
  console.out << "\nstopped: " << ladder.stopped << '\n';
  for (const auto& trial : ladder.refused)
    console.out << "  " << trial.name << ": "
                << (trial.why_not.empty()
                        ? "gain " + percent(trial.gain) + " +- " + percent(trial.gain_u) +
                              ", A90 " + fixed(trial.a90_rms * unit.factor, 1) + " " + unit.unit
                        : trial.why_not)
                << '\n';
  for (const auto& note : ladder.notes) console.out << note << '\n';
  console.out << "\nformula  " << ladder.formula() << '\n';
}

ExitCode grow(const Session& session, const StudyArguments& a) {
  identification::LadderOptions options;
  options.fit = fit_options(a.fit);
  options.fit.executor = executor_of(a.threads);
  const Dataset data = dataset_of(session, a, options.fit.executor);
  options.fit.candidates.outputs = outputs_of(data, a.outputs);
  options.together = a.together;
  options.folds = a.folds;
  options.most_order = a.most_order;
  options.least_gain = a.least_gain_pct / 100;
  const auto ladder = value_or_throw(identification::climb(data, options));
  if (session.console.json)
    session.console.print_json(ladder_json(ladder));
  else
    print_ladder(session.console, ladder);
  return ExitCode::done;
}

// Share by which twice the points would lower A90; none where the curve does not fall at its end:
// the slope that it comes from reaches back to sizes before the last two.
std::optional<double> doubling_forecast(const identification::LearningCurve& curve) {
  const auto count = curve.points.size();
  if (count < 2 || !(curve.gain_of_doubling > 0)) return std::nullopt;
  const auto &before = curve.points[count - 2], &last = curve.points[count - 1];
  const auto falls = [](const auto& from, const auto& to) {
    return from && to && to->a90 < from->a90;
  };
  if (!falls(before.random, last.random)) return std::nullopt;
  return curve.gain_of_doubling;
}

ordered_json curve_json(const identification::LearningCurve& curve) {
  const SummaryUnit unit = summary_unit(curve.unit);
  ordered_json json{{"schema", "driftwise.points.v1"},
                    {"held_out", curve.held_out},
                    {"rows_calibration", curve.rows},
                    {"terms_offered", curve.terms},
                    {"enough_rows", curve.enough},
                    {"gain_of_doubling", doubling_forecast(curve).value_or(0)}};
  json["points"] = ordered_json::array();
  for (const auto& point : curve.points) {
    ordered_json one{{"rows", point.rows}};
    const auto put = [&](const char* name, const auto& figure) {
      if (!figure) return;
      one[name]["a90_" + unit.unit] = figure->a90 * unit.factor;
      one[name]["a90_ci90_" + unit.unit] = {figure->low * unit.factor, figure->high * unit.factor};
    };
    put("random", point.random);
    put("space_filling", point.spread);
    json["points"].push_back(std::move(one));
  }
  return json;
}

void print_curve(const Console& console, const identification::LearningCurve& curve) {
  const SummaryUnit unit = summary_unit(curve.unit);
  Table table({{"points", Align::right},
               {"at random, A90 " + unit.unit, Align::right},
               {"90 % interval", Align::right},
               {"space-filling", Align::right},
               {"90 % interval", Align::right}});
  const auto text = [&](double value) { return fixed(value * unit.factor, 1); };
  for (const auto& point : curve.points) {
    std::vector<Table::Cell> row{std::to_string(point.rows)};
    for (const auto* figure : {&point.random, &point.spread}) {
      row.push_back(*figure ? text((*figure)->a90) : "too few");
      row.push_back(*figure ? text((*figure)->low) + " to " + text((*figure)->high) : "");
    }
    table.add(row);
  }
  console.out << "A90 held out (" << curve.held_out << ") of a fit to so many of the " << curve.rows
              << " calibration rows; " << curve.terms << " terms offered\n\n";
  table.print(console.out, console.paint_out());
  console.out << "\n" << curve.enough << " well-placed points are within 5 % of all; ";
  if (const auto gain = doubling_forecast(curve))
    console.out << "twice as many points as measured would lower A90 by about " << percent(*gain)
                << '\n';
  else
    console.out << "the curve does not fall at its end: more points would not lower A90 by more "
                   "than its scatter\n";
}

ExitCode points(const Session& session, const StudyArguments& a) {
  if (a.fit.formula.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "--model is required: the formula whose points are counted; `driftwise model "
                  "grow` finds one"};
  identification::CurveOptions options;
  options.fit = fit_options(a.fit);
  options.fit.executor = executor_of(a.threads);
  const Dataset data = dataset_of(session, a, options.fit.executor);
  options.fit.stopwatch_us = {};
  options.fit.candidates =
      value_or_throw(value_or_throw(formats::Formula::parse(a.fit.formula)).expand(data));
  options.together = a.together;
  options.folds = a.folds;
  options.sizes = a.sizes;
  options.draws = a.draws;
  options.seed = static_cast<std::uint64_t>(a.seed);
  const auto curve = value_or_throw(identification::learning_curve(data, options));
  if (session.console.json)
    session.console.print_json(curve_json(curve));
  else
    print_curve(session.console, curve);
  return ExitCode::done;
}

ordered_json table_json(const identification::SetTable& table) {
  ordered_json json{{"schema", "driftwise.table.v1"}};
  json["sets"] = ordered_json::array();
  for (std::size_t s = 0; s < table.sets.size(); ++s)
    json["sets"].push_back({{"set", table.sets[s]}, {"rows", table.rows[s]}});
  json["rows_unknown_datum"] = table.rows_unknown_datum;
  json["models"] = ordered_json::array();
  for (std::size_t m = 0; m < table.models.size(); ++m) {
    ordered_json model{{"model", table.models[m]}, {"terms", table.terms[m]}};
    for (std::size_t s = 0; s < table.sets.size(); ++s)
      for (const auto& figure : table.cells[m * table.sets.size() + s].outputs) {
        const SummaryUnit unit = summary_unit(figure.output.unit);
        model["rows"][table.sets[s]] = table.cells[m * table.sets.size() + s].rows;
        auto& cell = model["sets"][table.sets[s]][figure.output.symbol];
        cell["a90_" + unit.unit] = figure.figures.a90 * unit.factor;
        cell["mean_" + unit.unit] = figure.figures.mean * unit.factor;
        cell["u90_" + unit.unit] = figure.figures.u90 * unit.factor;
      }
    json["models"].push_back(std::move(model));
  }
  return json;
}

void print_sets(const Console& console, const identification::SetTable& sets) {
  const auto& outputs = sets.cells.front().outputs;
  std::vector<Table::Column> columns{
      {"model"}, {"terms", Align::right}, {"set"}, {"rows", Align::right}};
  for (const auto& figure : outputs) {
    const std::string unit = summary_unit(figure.output.unit).unit;
    columns.push_back({figure.output.symbol + " A90 " + unit, Align::right});
    columns.push_back({"mean", Align::right});
    columns.push_back({"S90", Align::right});
  }
  Table table(columns);
  for (std::size_t i = 0; i < sets.cells.size(); ++i) {
    const auto& cell = sets.cells[i];
    const std::size_t m = i / sets.sets.size(), s = i % sets.sets.size();
    std::vector<Table::Cell> row{s == 0 ? cell.model : "",
                                 s == 0 ? std::to_string(sets.terms[m]) : "", cell.set,
                                 std::to_string(cell.rows)};
    for (const auto& figure : cell.outputs) {
      const double factor = summary_unit(figure.output.unit).factor;
      row.push_back(fixed(figure.figures.a90 * factor, 1));
      row.push_back(signed_fixed(figure.figures.mean * factor, 1));
      row.push_back(fixed(figure.figures.u90 * factor, 1));
    }
    table.add(row);
  }
  table.print(console.out, console.paint_out());
  if (sets.rows_unknown_datum > 0)
    console.out << '\n'
                << sets.rows_unknown_datum
                << " validation rows left out: their datum has no calibration rows to take its "
                   "constant from\n";
  for (std::size_t i = 0; i < sets.cells.size(); ++i)
    if (const auto all = sets.rows[i % sets.sets.size()]; sets.cells[i].rows < all)
      console.out << '\n'
                  << sets.cells[i].model << ", " << sets.cells[i].set << ": "
                  << all - sets.cells[i].rows << " of " << all
                  << " rows left out: a channel that the model reads has no value there\n";
}

ExitCode table(const Session& session, const StudyArguments& a) {
  if (a.models.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "--model is required, once per row of the table: --model 'G: q ~ poly(x, y, z, "
                  "3)'"};
  const auto executor = executor_of(a.threads);
  const auto [data, words] = rows_of(session, a, executor);
  const auto sets = sets_of(a.sets, words);
  std::vector<identification::NamedFit> models;
  for (const auto& text : a.models) {
    const auto colon = text.find(':'), tilde = text.find('~');
    const bool named = colon != std::string::npos && tilde != std::string::npos && colon < tilde;
    identification::NamedFit one{.name = named ? text.substr(0, colon) : text, .fit = {}};
    if (std::ranges::any_of(models, [&](const auto& other) { return other.name == one.name; }))
      throw Failure{ExitCode::bad_input, "invalid_argument", reasons::kDuplicateId,
                    "--model: two rows of the table are named '" + one.name +
                        "': give each a name of its own"};
    one.fit = fit_options(a.fit);
    one.fit.executor = executor;
    one.fit.stopwatch_us = {};
    one.fit.candidates = value_or_throw(
        value_or_throw(formats::Formula::parse(named ? text.substr(colon + 1) : text))
            .expand(data));
    models.push_back(std::move(one));
  }
  const auto found = value_or_throw(identification::set_table(data, models, sets, words));
  if (session.console.json)
    session.console.print_json(table_json(found));
  else
    print_sets(session.console, found);
  return ExitCode::done;
}

void add_data_options(CLI::App& command, const std::shared_ptr<StudyArguments>& a) {
  command.add_option("FILE", a->file, "dataset CSV, - for standard input");
  command.add_option("--run", a->runs, "a run of the daemon instead; repeatable")
      ->allow_extra_args(false)
      ->check(positive_number());
  command.add_option("--threads", a->threads, "0: one per processor")
      ->check(number_between(0, 1024))
      ->capture_default_str();
}

void add_fold_options(CLI::App& command, const std::shared_ptr<StudyArguments>& a) {
  command.add_option("--together", a->together,
                     "rows that are held out together: line, or channels such as goal_x,goal_y; "
                     "without it contiguous blocks of time");
  command.add_option("--folds", a->folds, "parts held out in turn")
      ->check(number_between(2, 1000))
      ->capture_default_str();
}

}  // namespace

void add_grow_command(CLI::App& model, Session& session) {
  auto a = std::make_shared<StudyArguments>();
  CLI::App& command =
      add_command(model, session, "grow",
                  "Climbs the ladder of terms until rows held out are predicted no better",
                  [&session, a] { return grow(session, *a); });
  add_data_options(command, a);
  add_fold_options(command, a);
  command
      .add_option("--output", a->outputs,
                  "what is predicted: x,y or q1; else every motor coordinate")
      ->delimiter(',')
      ->allow_extra_args(false);
  command.add_option("--most-order", a->most_order, "of the geometry")
      ->check(number_between(1, 8))
      ->capture_default_str();
  command
      .add_option("--least-gain", a->least_gain_pct,
                  "percent of the held-out A90 below which nothing is gained")
      ->check(number_between(0.0, 100.0))
      ->capture_default_str();
}

void add_points_command(CLI::App& model, Session& session) {
  auto a = std::make_shared<StudyArguments>();
  CLI::App& command =
      add_command(model, session, "points", "How many points buy how many nm: a learning curve",
                  [&session, a] { return points(session, *a); });
  add_data_options(command, a);
  add_fold_options(command, a);
  command.add_option("--model", a->fit.formula, "formula: \"q ~ poly(x, y, z, 3) + T\"");
  command.add_option("--sizes", a->sizes, "numbers of points tried")
      ->check(number_between(2, 50))
      ->capture_default_str();
  command.add_option("--draws", a->draws, "random choices of each number, per part held out")
      ->check(number_between(1, 100))
      ->capture_default_str();
  command.add_option("--seed", a->seed, "of the random choices")
      ->check(number_from_zero())
      ->capture_default_str();
}

void add_table_command(CLI::App& model, Session& session) {
  auto a = std::make_shared<StudyArguments>();
  CLI::App& command =
      add_command(model, session, "table", "Models by named sets of validation rows by outputs",
                  [&session, a] { return table(session, *a); });
  add_data_options(command, a);
  command
      .add_option("--model", a->models,
                  "a row of the table: \"GT: q ~ poly(x, y, z, 3) + t04..t10\"; repeatable")
      ->allow_extra_args(false);
  command
      .add_option("--set", a->sets,
                  "a name of the data's column set, or validation rows by their channels: "
                  "\"inside: force 0.7..0.8\"; repeatable; "
                  "without it all of them")
      ->allow_extra_args(false);
}

}  // namespace driftwise::cli
