// `driftwise trajectory iso230-2 | iso230-3 | iso9283`.

#include <memory>

#include "clients/cli/commands/trajectories/standard_commands.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "clients/cli/core/value_or_throw.h"
#include "server/formats/csv/trajectory_csv.h"
#include "server/standards/standard_plans.h"

namespace driftwise::cli {
namespace {

struct PlanArguments {
  std::string axis = "q1", file;
  std::vector<std::string> axes = {"q1", "q2", "q3"}, held;
  standards::Iso2302Plan iso230_2;
  standards::Iso2303Plan iso230_3;
  standards::Iso9283Plan iso9283;
  bool even = false;
};

// A coordinate of a trajectory, written without its unit.
Channel coordinate_of(const std::string& symbol) {
  const auto channel = parse_robot_channel(symbol + "_mm");
  const auto name = without_robot(symbol);
  if (!channel || !(is_motor_symbol(name) || name == "x" || name == "y" || name == "z"))
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "found the coordinate '" + symbol +
                      "', expected q1, q2, ... or x, y, z, in a cell of several robots with the "
                      "robot's id: ma.q1"};
  return *channel;
}

std::vector<standards::Held> held_of(const std::vector<std::string>& texts) {
  std::vector<standards::Held> out;
  for (const auto& text : texts) {
    const auto equals = text.find('=');
    const auto at_mm =
        equals == std::string::npos ? std::nullopt : number_from(text.substr(equals + 1));
    if (!at_mm)
      throw Failure{
          ExitCode::usage, "usage", "USAGE",
          "found --hold " + text + ", expected a coordinate and its place such as q2=1.25"};
    out.push_back({coordinate_of(text.substr(0, equals)), *at_mm});
  }
  return out;
}

ExitCode write_plan(const Console& console, const PlanArguments& a, const char* standard,
                    const Trajectory& trajectory) {
  const std::string csv = std::string("# ") + standard + ", made by driftwise trajectory\n" +
                          formats::write_trajectory_csv(trajectory);
  value_or_throw(formats::read_trajectory_csv(csv, "this trajectory"));
  if (a.file.empty() || a.file == "-") {
    console.out << csv << std::flush;
    return ExitCode::done;
  }
  write_output_file(a.file, csv);
  if (console.json)
    console.print_json({{"file", a.file}, {"points", trajectory.points.size()}});
  else
    console.err << a.file << ": " << trajectory.points.size() << " points\n";
  return ExitCode::done;
}

void add_plan_options(CLI::App& command, PlanArguments& a) {
  command.add_option("--hold", a.held, "another coordinate's place: q2=1.25; repeatable");
  command.add_option("-o,--output", a.file, "trajectory CSV; without it standard output");
}

void add_iso230_2_plan(CLI::App& parent, Session& session) {
  auto a = std::make_shared<PlanArguments>();
  auto& plan = a->iso230_2;
  CLI::App& command =
      add_command(parent, session, "iso230-2",
                  "Five passes up and down over target positions, turning round beyond the ends",
                  [&session, a] {
                    a->iso230_2.axis = coordinate_of(a->axis);
                    a->iso230_2.held = held_of(a->held);
                    if (a->even) a->iso230_2.scatter = 0;
                    return write_plan(session.console, *a, "ISO 230-2",
                                      value_or_throw(standards::iso230_2_plan(a->iso230_2)));
                  });
  command.add_option("--axis", a->axis, "coordinate that moves")->capture_default_str();
  command.add_option("--from", plan.from_mm, "mm, the lowest position")->required();
  command.add_option("--to", plan.to_mm, "mm, the highest")->required();
  command.add_option("--positions", plan.positions, "from end to end")->capture_default_str();
  command.add_option("--approaches", plan.approaches, "from each side")->capture_default_str();
  command.add_option("--overrun", plan.overrun_mm, "mm beyond the ends; else a quarter of a step");
  command.add_flag("--even", a->even, "positions at equal steps, not scattered within them");
  command.add_option("--seed", plan.seed, "of the scatter")->capture_default_str();
  add_plan_options(command, *a);
}

void add_iso230_3_plan(CLI::App& parent, Session& session) {
  auto a = std::make_shared<PlanArguments>();
  auto& plan = a->iso230_3;
  CLI::App& command = add_command(
      parent, session, "iso230-3",
      "Positions visited from below again and again, or one at rest, for hours", [&session, a] {
        a->iso230_3.axis = coordinate_of(a->axis);
        a->iso230_3.held = held_of(a->held);
        return write_plan(session.console, *a, "ISO 230-3",
                          value_or_throw(standards::iso230_3_plan(a->iso230_3)));
      });
  command.add_option("--axis", a->axis, "coordinate that moves")->capture_default_str();
  command.add_option("--at", plan.at_mm, "mm: -4,4 or one position")->delimiter(',')->required();
  command.add_option("--hours", plan.hours, "that the test lasts")->capture_default_str();
  command.add_option("--every", plan.every_s, "seconds that a round dwells")->capture_default_str();
  command.add_option("--overrun", plan.overrun_mm, "mm below the lowest")->capture_default_str();
  add_plan_options(command, *a);
}

void add_iso9283_plan(CLI::App& parent, Session& session) {
  auto a = std::make_shared<PlanArguments>();
  auto& plan = a->iso9283;
  CLI::App& command = add_command(
      parent, session, "iso9283",
      "Five poses in a cube, thirty cycles, each always approached alike", [&session, a] {
        a->iso9283.axes.clear();
        for (const auto& axis : a->axes) a->iso9283.axes.push_back(coordinate_of(axis));
        a->iso9283.held = held_of(a->held);
        return write_plan(session.console, *a, "ISO 9283",
                          value_or_throw(standards::iso9283_plan(a->iso9283)));
      });
  command.add_option("--axes", a->axes, "one to three")->delimiter(',')->capture_default_str();
  command.add_option("--centre", plan.centre_mm, "mm, of the cube: 1.25,1.25,1.25")
      ->delimiter(',')
      ->required();
  command.add_option("--edge", plan.edge_mm, "mm, of the cube")->required();
  command.add_option("--cycles", plan.cycles, "visits of each pose")->capture_default_str();
  add_plan_options(command, *a);
}

}  // namespace

void add_standard_trajectories(CLI::App& trajectory, Session& session) {
  add_iso230_2_plan(trajectory, session);
  add_iso230_3_plan(trajectory, session);
  add_iso9283_plan(trajectory, session);
}

}  // namespace driftwise::cli
