#include "clients/cli/commands/trajectories/kept_trajectory_commands.h"

#include <charconv>
#include <memory>
#include <optional>
#include <vector>

#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/validators.h"
#include "driftwise/v1/trajectory_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using TrajectoryStub = v1::TrajectoryService::Stub;

struct GenerateArguments {
  std::vector<std::string> axes;  // "q1_mm=0:2.5:6"
  std::vector<double> forces_n;
  std::int32_t line_length = 0, repeats = 1;
  bool validation = false, both_directions = false;
  std::optional<std::int64_t> seed;
  std::string file, keep_as;
};

[[noreturn]] void bad_grid_axis(const std::string& text) {
  throw Failure{ExitCode::usage, "invalid_argument", "BAD_AXIS",
                "--axis: found '" + text + "', expected such as q1_mm=0:2.5:6 (from, to, count)"};
}

template <class Number>
Number grid_number(const std::string& whole, std::string_view part) {
  Number out{};
  const auto [end, bad] = std::from_chars(part.data(), part.data() + part.size(), out);
  if (bad != std::errc{} || end != part.data() + part.size()) bad_grid_axis(whole);
  return out;
}

v1::GridAxis grid_axis_from(const std::string& text) {
  const auto equals = text.find('='), first = text.find(':', equals),
             second = text.find(':', first + 1);
  if (equals == std::string::npos || first == std::string::npos || second == std::string::npos)
    bad_grid_axis(text);
  const std::string_view view(text);
  v1::GridAxis axis;
  axis.set_coordinate(text.substr(0, equals));
  axis.set_from_mm(grid_number<double>(text, view.substr(equals + 1, first - equals - 1)));
  axis.set_to_mm(grid_number<double>(text, view.substr(first + 1, second - first - 1)));
  axis.set_count(grid_number<std::int32_t>(text, view.substr(second + 1)));
  return axis;
}

void print_kept(const Console& console, const v1::Trajectory& kept) {
  if (console.json) return console.print_json(json_from(kept));
  console.out << "trajectory " << kept.id() << " '" << kept.name() << "', " << kept.row_count()
              << " rows, kept by " << kept.created_by() << " " << utc_text(kept.create_time())
              << '\n';
}

v1::Trajectory kept_in_daemon(const Connection& connection, const std::string& name,
                              const std::string& text) {
  v1::CreateTrajectoryRequest request;
  request.set_name(name);
  request.set_text(text);
  return connection.ask(&TrajectoryStub::CreateTrajectory, request).trajectory();
}

ExitCode list_kept(const Session& session) {
  const auto response =
      session.connect().ask(&TrajectoryStub::ListTrajectories, v1::ListTrajectoriesRequest{});
  if (session.console.json) {
    session.console.print_json(json_from(response));
    return ExitCode::done;
  }
  Table table(
      {{"trajectory", Align::right}, {"name"}, {"rows", Align::right}, {"kept (UTC)"}, {"by"}});
  for (const auto& kept : response.trajectories())
    table.add({std::to_string(kept.id()), kept.name(), std::to_string(kept.row_count()),
               clock_text(kept.create_time()), kept.created_by()});
  table.print(session.console.out, session.console.paint_out());
  return ExitCode::done;
}

ExitCode show_kept(const Session& session, std::int64_t id) {
  v1::GetTrajectoryRequest request;
  request.set_trajectory_id(id);
  const auto kept = session.connect().ask(&TrajectoryStub::GetTrajectory, request).trajectory();
  if (session.console.json)
    session.console.print_json(json_from(kept));
  else
    session.console.out << kept.text();
  return ExitCode::done;
}

ExitCode generate_grid(const Session& session, const GenerateArguments& a) {
  v1::GenerateTrajectoryRequest request;
  for (const auto& axis : a.axes) *request.add_axes() = grid_axis_from(axis);
  request.mutable_forces_n()->Assign(a.forces_n.begin(), a.forces_n.end());
  request.set_line_length(a.line_length);
  request.set_repeat_count(a.repeats);
  request.set_with_validation(a.validation);
  request.set_both_directions(a.both_directions);
  if (a.seed) request.set_shuffle_seed(*a.seed);
  const auto connection = session.connect();
  const auto made = connection.ask(&TrajectoryStub::GenerateTrajectory, request);
  if (!a.file.empty()) write_output_file(a.file, made.text());
  if (!a.keep_as.empty()) {
    print_kept(session.console, kept_in_daemon(connection, a.keep_as, made.text()));
  } else if (a.file.empty()) {
    session.console.out << made.text();
  } else if (session.console.json) {
    session.console.print_json({{"file", a.file}, {"rows", made.row_count()}});
  } else {
    session.console.out << a.file << ": " << made.row_count() << " rows\n";
  }
  return ExitCode::done;
}

}  // namespace

void add_kept_trajectories(CLI::App& trajectory, Session& session) {
  struct UploadArguments {
    std::string file, name;
  };
  auto a = std::make_shared<UploadArguments>();
  CLI::App& upload = add_command(
      trajectory, session, "upload", "Checks a trajectory and keeps it in the daemon",
      [&session, a] {
        print_kept(session.console,
                   kept_in_daemon(session.connect(), a->name.empty() ? base_name(a->file) : a->name,
                                  read_input_file(a->file)));
        return ExitCode::done;
      });
  upload.add_option("FILE", a->file, "trajectory CSV, - for standard input")->required();
  upload.add_option("--name", a->name, "for people; without it the file's name");
  add_command(trajectory, session, "list", "The trajectories kept in the daemon",
              [&session] { return list_kept(session); });
  auto id = std::make_shared<std::int64_t>(0);
  CLI::App& show = add_command(trajectory, session, "show", "A kept trajectory as it was uploaded",
                               [&session, id] { return show_kept(session, *id); });
  show.add_option("TRAJECTORY", *id, "its number")->required()->check(positive_number());

  auto g = std::make_shared<GenerateArguments>();
  CLI::App& make = add_command(
      trajectory, session, "generate",
      "Makes a grid within the cell's limits: returns to zero, validation, forces, directions",
      [&session, g] { return generate_grid(session, *g); });
  make.add_option("--axis", g->axes, "q1_mm=0:2.5:6, again for each axis; the first moves fastest")
      ->required();
  make.add_option("--force", g->forces_n, "newton; the whole grid under each")->delimiter(',');
  make.add_option("--line-length", g->line_length, "points between two returns to zero");
  make.add_option("--repeat", g->repeats, "passes")->capture_default_str();
  make.add_flag("--validation", g->validation, "also the middles of the grid's cells");
  make.add_flag("--both-directions", g->both_directions, "every second pass backwards");
  make.add_option("--shuffle", g->seed, "a random order that this seed repeats");
  make.add_option("-o,--output", g->file, "trajectory CSV; without it standard output");
  make.add_option("--keep", g->keep_as, "keeps it in the daemon under this name");
}

}  // namespace driftwise::cli
