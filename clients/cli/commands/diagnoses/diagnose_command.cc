#include "clients/cli/commands/diagnoses/diagnose_command.h"

#include <memory>

#include "clients/cli/commands/diagnoses/diagnosis_commands.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/core/value_or_throw.h"
#include "server/diagnosis/diagnose.h"
#include "server/diagnosis/report/left_unread.h"
#include "server/diagnosis/robot/robot_diagnosis.h"
#include "server/diagnosis/rows/catalogue_units.h"
#include "server/diagnosis/separating/separating.h"
#include "server/formats/cell_file/kinematics_section.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/diagnosis/diagnosis_html.h"
#include "server/formats/diagnosis/diagnosis_json.h"
#include "server/formats/diagnosis/robot_names.h"
#include "server/formats/diagnosis/separating_text.h"
#include "server/formats/formula/formula.h"
#include "server/threads/threaded_executor.h"

namespace driftwise::cli {
namespace {

struct DiagnoseArguments {
  std::string file, baseline, kinematics, robot_out;
  double alpha = 0.003;
  int nulls = 199, most = 8, threads = threads::processors();
  std::vector<std::string> without;
  std::uint64_t seed = 1;
  std::string report, separating;
  double budget_h = 4;
  std::vector<std::int64_t> runs;  // of the daemon, instead of a file
  std::int64_t model = 0;
  std::string name, robot;
};

constexpr double kSecondsPerHour = 3600;

// The measurement that would tell an indistinguishable set apart, within what the data have seen: a
// trajectory is in mm or arcsec, whatever the file's units.
void add_separating(const Session& session, const DiagnoseArguments& a, const Dataset& given,
                    const formats::RobotNames& names, const calibration::Candidates& baseline,
                    diagnosis::Diagnosis& found) {
  const Dataset data = diagnosis::in_catalogue_units(given);
  auto limits = diagnosis::limits_from(data);
  limits.budget_s = a.budget_h * kSecondsPerHour;
  const auto plan =
      diagnosis::separating_plan(data, diagnosis::in_catalogue_units(baseline), found, limits);
  if (!plan) {
    found.warnings.push_back("no separating measurement was designed: " + plan.error().message);
    return;
  }
  if (*plan) found.separating_experiment = formats::separating_text(**plan);
  if (a.separating.empty()) return;
  if (found.separating_experiment && !found.separating_experiment->trajectory_csv.empty()) {
    write_output_file(a.separating, names.with_id(found.separating_experiment->trajectory_csv),
                      {a.file});
    session.console.err << "separating trajectory: " << a.separating << ", "
                        << span_text(found.separating_experiment->estimated_s) << "\n";
  } else
    session.console.err << "no separating trajectory: "
                        << (found.separating_experiment ? found.separating_experiment->why
                                                        : "nothing is indistinguishable")
                        << "\n";
}

// Against the drawing of a robot: a finding is a number of it, the rest comes beyond it.
diagnosis::Diagnosis of_robot(const DiagnoseArguments& a, const Dataset& data,
                              const diagnosis::DiagnoseOptions& options) {
  const auto mechanism = value_or_throw(kinematics::make_mechanism(
      value_or_throw(formats::parse_robot_file(read_input_file(a.kinematics), a.kinematics))));
  auto found = value_or_throw(diagnosis::diagnose_robot(data, mechanism, options));
  if (auto said = diagnosis::unread_pose_note(data, *mechanism); !said.empty())
    found.diagnosis.warnings.push_back(std::move(said));
  if (!a.robot_out.empty())
    write_output_file(a.robot_out, formats::write_robot_file(found.robot), {a.file, a.kinematics});
  return std::move(found.diagnosis);
}

std::vector<std::string> known_channels(const std::vector<std::string>& asked, const Dataset& data,
                                        const std::string& file) {
  for (const auto& symbol : asked) {
    if (data.find(symbol) != nullptr) continue;
    std::string known;
    for (const auto& column : data.columns) known += " " + column.channel.symbol;
    throw Failure{ExitCode::bad_input, "invalid_argument", "UNKNOWN_CHANNEL",
                  "--without: unknown channel '" + symbol + "', " + file + " has:" + known};
  }
  return asked;
}

ExitCode diagnose_file(const Session& session, const DiagnoseArguments& a) {
  const Dataset given = value_or_throw(formats::read_dataset_csv(read_input_file(a.file), a.file));
  const formats::RobotNames names(
      given, value_or_throw(formats::robot_asked_for(given, a.baseline, a.robot)));
  const Dataset data = names.bare(given);
  diagnosis::DiagnoseOptions options;
  if (!a.baseline.empty())
    options.baseline = value_or_throw(
        value_or_throw(formats::Formula::parse(names.bare(a.baseline))).expand(data));
  options.alpha = a.alpha;
  options.nulls = a.nulls;
  options.max_findings = a.most;
  options.seed = a.seed;
  for (const auto& symbol : known_channels(a.without, given, a.file))
    options.exclude_symbols.push_back(names.bare(symbol));
  options.executor = threads::threaded_executor(a.threads);
  if (session.console.err_is_terminal)
    options.progress = [&session, last = std::string()](double, const std::string& step) mutable {
      if (step != last) session.console.err << step << " ...\n" << std::flush;
      last = step;
      return true;
    };
  auto found = a.kinematics.empty() ? value_or_throw(diagnosis::diagnose(data, options))
                                    : of_robot(a, data, options);
  if (a.budget_h > 0 && a.kinematics.empty())
    add_separating(session, a, data, names, options.baseline, found);
  found = names.with_id(std::move(found));
  if (!a.report.empty()) {
    const std::string of = names.robot().empty() ? a.file : a.file + ", robot " + names.robot();
    write_output_file(a.report, formats::diagnosis_html(found, given, {"Diagnosis of " + of, of}),
                      {a.file});
  }
  if (session.console.json)
    session.console.print_json(formats::diagnosis_json(found));
  else
    session.console.out << formats::diagnosis_page(found);
  return found.verdict == diagnosis::Verdict::unexplained ? ExitCode::negative : ExitCode::done;
}

[[noreturn]] void misused(const std::string& message) {
  throw Failure{ExitCode::usage, "usage", "USAGE", message};
}

// Options of a file's diagnosis, which the daemon's diagnosis of runs does not read: refused, not
// dropped without a word.
void refuse_file_options(const CLI::App& command) {
  for (const char* name :
       {"--report", "--separating", "--robot-out", "--nulls", "--most", "--budget", "--threads"})
    if (command.count(name) > 0)
      misused(std::string(name) +
              " goes with a file, and the daemon diagnoses runs: leave it out and write what was "
              "found by driftwise diagnosis export N -o FILE, or export the runs first (driftwise "
              "data export)");
}

ExitCode diagnose_any(const Session& session, const DiagnoseArguments& a, const CLI::App& command) {
  if (a.file.empty() == a.runs.empty())
    misused("give a file or runs, one of the two: driftwise diagnose FILE.csv, or --run 3");
  if (!a.runs.empty() && !a.kinematics.empty())
    misused("--kinematics goes with a file: export the runs first (driftwise data export)");
  if (!a.runs.empty()) refuse_file_options(command);
  if (!a.runs.empty())
    return diagnose_runs(
        session, {a.runs, a.model, a.baseline, a.name, a.alpha, a.seed, a.without, a.robot});
  if (a.model != 0) misused("--model names a model of the daemon: it goes with --run");
  if (a.baseline.empty() && a.kinematics.empty())
    misused("a file needs --baseline, the simulation as it is, or --kinematics robot.toml");
  return diagnose_file(session, a);
}

}  // namespace

void add_diagnose_command(CLI::App& app, Session& session) {
  auto a = std::make_shared<DiagnoseArguments>();
  CLI::App& command = add_command(
      app, session, "diagnose", "What the simulation gets wrong in these data, and why",
      [&session, a, &app] { return diagnose_any(session, *a, *app.get_subcommand("diagnose")); });
  command.add_option("FILE", a->file, "dataset CSV, - for standard input");
  command
      .add_option("--run", a->runs, "these runs instead, such as 3,4: the daemon diagnoses them")
      ->delimiter(',')
      ->check(positive_number());
  command.add_option(
      "--baseline", a->baseline,
      "the simulation as it is: \"q ~ x + x^2 + T\"; all of its terms are in. Of runs: "
      "else that of --model, or of the model that serves");
  command.add_option("--kinematics", a->kinematics,
                     "of a file: the robot's drawing is the simulation; robot file or cell.toml "
                     "(docs/kinematics.md)");
  command.add_option("--robot-out", a->robot_out,
                     "write the drawing with what was found: identified.toml");
  command.add_option("--model", a->model, "of runs: begins from this model of the daemon")
      ->check(positive_number());
  command.add_option("--robot", a->robot,
                     "of a cell with several: ma; else the one that the baseline's outputs name");
  command.add_option("--name", a->name, "of runs: of the diagnosis, for the record");
  command.add_option("--alpha", a->alpha, "rate of a false name where nothing is wrong")
      ->check(number_between(1e-6, 0.5))
      ->capture_default_str();
  command.add_option("--nulls", a->nulls, "series of noise that the search is held against")
      ->check(number_between(20, 9999))
      ->capture_default_str();
  command.add_option("--most", a->most, "findings at most")
      ->check(number_between(1, 8))
      ->capture_default_str();
  command.add_option("--without", a->without, "channels that no cause may read: t03,air")
      ->delimiter(',');
  command.add_option("--threads", a->threads, "at work")
      ->check(number_between(1, 64))
      ->capture_default_str();
  command.add_option("--report", a->report, "write a page to look at: out.html");
  command
      .add_option("--budget", a->budget_h,
                  "hours that a separating measurement may take; 0: design none")
      ->check(number_between(0.0, 1000.0))
      ->capture_default_str();
  command.add_option("--separating", a->separating, "write its trajectory: plan.csv");
  command.add_option("--seed", a->seed, "of those series")->capture_default_str();
}

}  // namespace driftwise::cli
