#include "clients/cli/commands/trajectories/standard_commands.h"

#include <memory>

#include "clients/cli/commands/data/exported_csv.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/core/value_or_throw.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/standards/standards_json.h"
#include "server/formats/standards/standards_page.h"

namespace driftwise::cli {
namespace {

struct StandardArguments {
  std::string file;
  std::int64_t run = 0;
  standards::Iso2302Options iso230_2;
  standards::Iso2303Options iso230_3;
  standards::Iso9283Options iso9283;
  bool repeatability_only = false;
};

// The run's dataset is exact to the last digit: the figures here are the daemon's. Rows kept out
// stay in it, marked: they are no figures, but the next row comes from where they are.
Dataset dataset_of(const Session& session, const StandardArguments& a) {
  if (a.file.empty() == (a.run == 0))
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  std::string("of what? found ") + (a.file.empty() ? "neither" : "both") +
                      " a file and --run; give one of them"};
  if (!a.file.empty())
    return value_or_throw(formats::read_dataset_csv(read_input_file(a.file), a.file));
  return value_or_throw(formats::read_dataset_csv(exported_csv(session, {a.run}, false),
                                                  "run " + std::to_string(a.run)));
}

// What lacks something is refused (5), what is no such table is bad input (3).
template <class Figures>
ExitCode print_figures(const Session& session, const StandardArguments& a,
                       Result<Figures> figures) {
  if (!figures) {
    Failure failure = failure_of(figures.error());
    if (figures.error().code == ErrorCode::failed_precondition) failure.exit = ExitCode::refused;
    failure.message =
        (a.file.empty() ? "run " + std::to_string(a.run) : a.file) + ": " + failure.message;
    throw failure;
  }
  if (session.console.json)
    session.console.print_json(formats::standards_json(*figures));
  else
    session.console.out << formats::standards_page(*figures);
  return ExitCode::done;
}

void add_source(CLI::App& command, StandardArguments& a) {
  command.add_option("FILE", a.file, "dataset CSV, - for standard input");
  command.add_option("--run", a.run, "a run at the daemon instead")->check(positive_number());
}

void add_axis(CLI::App& command, standards::AxisColumns& columns) {
  command
      .add_option("--axis", columns.axis, "q1, q2, q3, x, y or z; of one of several robots ma.q1")
      ->capture_default_str();
  command.add_option(
      "--target", columns.target,
      "column of what was wanted, without its unit; else x_target, goal_x or q1_cmd");
  command.add_option("--measured", columns.measured,
                     "column of what was measured; else x, of q2 y, of q3 z");
}

void add_iso230_2(CLI::App& parent, Session& session) {
  auto a = std::make_shared<StandardArguments>();
  CLI::App& command =
      add_command(parent, session, "iso230-2",
                  "Accuracy and repeatability of an axis: A, R, E, M, B", [&session, a] {
                    return print_figures(session, *a,
                                         standards::iso230_2(dataset_of(session, *a), a->iso230_2));
                  });
  add_source(command, *a);
  add_axis(command, a->iso230_2.columns);
  command.add_option("--approaches", a->iso230_2.approaches, "from each side")
      ->check(number_between(5, 1000))
      ->capture_default_str();
}

void add_iso230_3(CLI::App& parent, Session& session) {
  auto a = std::make_shared<StandardArguments>();
  CLI::App& command =
      add_command(parent, session, "iso230-3", "Thermal drift of positions, with the temperatures",
                  [&session, a] {
                    return print_figures(session, *a,
                                         standards::iso230_3(dataset_of(session, *a), a->iso230_3));
                  });
  add_source(command, *a);
  add_axis(command, a->iso230_3.columns);
  command.add_option("--hours", a->iso230_3.hours, "the test lasts at least so long")
      ->check(positive_number())
      ->capture_default_str();
  command
      .add_option("--window", a->iso230_3.windows_min,
                  "minutes, several separated by commas; the worst drift within each")
      ->delimiter(',')
      ->check(positive_number())
      ->capture_default_str();
  command.add_option("--longest-gap", a->iso230_3.longest_gap_min, "minutes between two visits")
      ->check(positive_number())
      ->capture_default_str();
}

void add_iso9283(CLI::App& parent, Session& session) {
  auto a = std::make_shared<StandardArguments>();
  auto& options = a->iso9283;
  CLI::App& command = add_command(
      parent, session, "iso9283", "Pose accuracy and repeatability of a robot: AP, RP",
      [&session, a] {
        a->iso9283.accuracy = !a->repeatability_only;
        return print_figures(session, *a, standards::iso9283(dataset_of(session, *a), a->iso9283));
      });
  add_source(command, *a);
  command
      .add_option("--command", options.command,
                  "columns of what was wanted, without units; else x_target, goal_x or q1_cmd, ...")
      ->delimiter(',');
  command.add_option("--measured", options.measured, "columns of what was measured; else x, y, z")
      ->delimiter(',');
  command.add_option("--rotation-command", options.rotation_command, "the same of rotations")
      ->delimiter(',');
  command.add_option("--rotation-measured", options.rotation_measured, "else rx, ry, rz")
      ->delimiter(',');
  command.add_option("--poses", options.poses, "different ones that must be there")
      ->check(number_between(1, 1000))
      ->capture_default_str();
  command.add_option("--cycles", options.cycles, "visits of each pose at least")
      ->check(number_between(2, 100000))
      ->capture_default_str();
  command.add_option("--same-pose-mm", options.same_pose_mm, "commands so near are one pose")
      ->check(positive_number())
      ->capture_default_str();
  command.add_option("--same-pose-arcsec", options.same_pose_arcsec, "the same of their rotations")
      ->check(positive_number())
      ->capture_default_str();
  command.add_flag("--repeatability-only", a->repeatability_only,
                   "commands and measurements stand in different frames: RP alone");
}

}  // namespace

void add_standard_commands(CLI::App& app, Session& session) {
  CLI::App& standard =
      *app.add_subcommand("standard", "Figures by published standards, of a run or a dataset CSV")
           ->require_subcommand(1);
  add_iso230_2(standard, session);
  add_iso230_3(standard, session);
  add_iso9283(standard, session);
}

}  // namespace driftwise::cli
