#include "clients/cli/commands/trajectories/trajectory_grid_command.h"

#include <cmath>
#include <memory>

#include "clients/cli/commands/trajectories/plan_block_text.h"
#include "server/formats/cell_file/kinematics_section.h"
#include "server/formats/csv/trajectory_csv.h"
#include "server/kinematics/delta.h"

namespace driftwise::cli {
namespace {

struct GridArguments {
  std::string axes, file, kinematics;
  std::vector<std::string> blocks;
};

template <class T>
T must_have(Result<T> result) {
  if (!result)
    throw Failure{ExitCode::usage, std::string(to_string(result.error().code)),
                  result.error().reason, result.error().message};
  return std::move(*result);
}

// The file says how it was made.
std::string header_of(const GridArguments& a) {
  std::string text =
      "# driftwise-trajectory: 1\n# made by: driftwise trajectory grid --axes " + a.axes;
  for (const auto& block : a.blocks) text += " --block '" + block + "'";
  if (!a.kinematics.empty()) text += " --to-pose " + base_name(a.kinematics);
  return text + "\n";
}

// Where the drawing says that the robot stands, to 0.1 um: poses that are inside its workspace.
void take_to_pose(Trajectory& trajectory, const std::string& file) {
  const auto description = must_have(formats::parse_robot_file(read_input_file(file), file));
  const auto delta = must_have(kinematics::Delta::create(description));
  if (delta.outputs() != trajectory.coordinates)
    throw Failure{ExitCode::usage, "invalid_argument", "WRONG_COORDINATES",
                  "--to-pose: expected --axes with every motor of " + file + ", in its order"};
  const auto nominal = kinematics::nominal_values(delta.parameters());
  for (auto& point : trajectory.points) {
    const Eigen::Vector3d q_mm(point.target[0], point.target[1], point.target[2]);
    const auto pose = must_have(delta.pose_from_motor(q_mm, nominal));
    for (Eigen::Index i = 0; i < 3; ++i)
      point.target[static_cast<std::size_t>(i)] =
          point.zero ? 0.0 : std::round(pose[i] * 1e4) / 1e4 + 0.0;  // -0 + 0 is 0
  }
  trajectory.coordinates = delta.inputs();
}

ExitCode make_grid(const Session& session, const GridArguments& a) {
  Trajectory trajectory;
  trajectory.coordinates = must_have(coordinates_from(a.axes));
  nlohmann::ordered_json blocks = nlohmann::ordered_json::array();
  for (const auto& text : a.blocks) {
    const auto before = trajectory.points.size();
    const auto block = must_have(plan_block_from(text, trajectory.coordinates));
    if (const auto ok = append_block(trajectory, block); !ok)
      must_have<int>(tl::unexpected(ok.error()));
    blocks.push_back({{"block", text}, {"points", trajectory.points.size() - before}});
  }
  if (!a.kinematics.empty()) take_to_pose(trajectory, a.kinematics);
  const auto csv = header_of(a) + formats::write_trajectory_csv(trajectory);
  must_have(formats::read_trajectory_csv(csv, "this trajectory"));
  if (a.file.empty() || a.file == "-") {
    session.console.out << csv;
    return ExitCode::done;
  }
  write_output_file(a.file, csv);
  if (session.console.json)
    session.console.print_json(
        {{"file", a.file}, {"points", trajectory.points.size()}, {"blocks", blocks}});
  else
    session.console.out << a.file << ": " << trajectory.points.size() << " points in "
                        << a.blocks.size() << " block" << (a.blocks.size() == 1 ? "" : "s") << '\n';
  return ExitCode::done;
}

}  // namespace

void add_trajectory_grid(CLI::App& trajectory, Session& session) {
  auto a = std::make_shared<GridArguments>();
  CLI::App& command = add_command(
      trajectory, session, "grid",
      "Makes a trajectory out of blocks: grids with returns to zero, scattered positions",
      [&session, a] { return make_grid(session, *a); });
  command.add_option("--axes", a->axes, "coordinates without their unit, such as q1,q2,q3")
      ->required();
  command
      .add_option("--block", a->blocks,
                  "'calibration 0:2.5:0.5 force=2.305 dwell=15', 'validation 0.1:2.4 scattered=94 "
                  "seed=7'; again for each block, in order")
      ->required();
  command.add_option("--to-pose", a->kinematics,
                     "cell.toml or robot file: writes the poses x, y, z that its nominal "
                     "kinematics has at these motor coordinates");
  command.add_option("-o,--output", a->file, "trajectory CSV; without it standard output");
}

}  // namespace driftwise::cli
