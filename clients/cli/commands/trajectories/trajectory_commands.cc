#include <memory>

#include "clients/cli/commands/runs/run_commands.h"
#include "clients/cli/commands/trajectories/kept_trajectory_commands.h"
#include "clients/cli/commands/trajectories/standard_commands.h"
#include "clients/cli/commands/trajectories/trajectory_grid_command.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/trajectory_check.h"
#include "clients/cli/pages/band_text.h"

namespace driftwise::cli {

v1::CheckTrajectoryResponse check_trajectory(const Connection& connection, const std::string& text,
                                             const std::string& file) {
  v1::CheckTrajectoryRequest request;
  request.set_trajectory_text(text);
  try {
    return connection.ask(&v1::RunService::Stub::CheckTrajectory, request);
  } catch (Failure& failure) {
    // The daemon never saw the file's name: its messages begin with "trajectory:LINE:".
    constexpr std::string_view kUnnamed = "trajectory:";
    if (failure.message.starts_with(kUnnamed))
      failure.message.replace(0, kUnnamed.size() - 1, file);
    else if (failure.exit == ExitCode::bad_input && failure.message.find(file) == std::string::npos)
      failure.message = file + ": " + failure.message;
    throw;
  }
}

void print_check(const Console& console, const v1::CheckTrajectoryResponse& check,
                 const std::string& file) {
  if (console.json) {
    auto json = json_from(check);
    json["file"] = file;
    return console.print_json(json);
  }
  const Paint paint = console.paint_out();
  std::string coordinates;
  for (const auto& coordinate : check.coordinates())
    coordinates += (coordinates.empty() ? "" : ", ") + coordinate;
  console.out << file << ": " << paint.good("good") << '\n'
              << "  " << check.row_count() << " points (" << check.calibration_count()
              << " calibration, " << check.validation_count() << " validation) on "
              << check.line_count() << (check.line_count() == 1 ? " line, " : " lines, ")
              << check.zero_count()
              << (check.zero_count() == 1 ? " return to zero, in " : " returns to zero, in ")
              << coordinates << '\n'
              << "  takes about " << span_text(seconds_of(check.estimated_duration()))
              << " of cell time (" << band_text(check.estimated_band()) << ")\n";
  for (const auto& warning : check.warnings())
    console.out << "  " << paint.warn("warning: ") << warning << '\n';
}

void add_trajectory_commands(CLI::App& app, Session& session) {
  CLI::App& trajectory =
      *app.add_subcommand("trajectory", "Files of points to visit")->require_subcommand(1);
  auto file = std::make_shared<std::string>();
  CLI::App& check = add_command(
      trajectory, session, "check",
      "Reads a trajectory and says what a run of it would do; moves nothing", [&session, file] {
        const std::string text = read_input_file(*file);
        print_check(session.console, check_trajectory(session.connect(), text, *file), *file);
        return ExitCode::done;
      });
  check.add_option("FILE", *file, "trajectory CSV, - for standard input")->required();
  add_kept_trajectories(trajectory, session);
  add_trajectory_grid(trajectory, session);
  add_sigma6_command(trajectory, session);
  add_standard_trajectories(trajectory, session);
}

}  // namespace driftwise::cli
