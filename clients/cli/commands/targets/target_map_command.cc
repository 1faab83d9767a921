#include "clients/cli/commands/targets/target_map_command.h"

#include <algorithm>
#include <memory>

#include "clients/cli/core/assignment.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "driftwise/v1/target_service.grpc.pb.h"
#include "server/formats/text/text.h"

namespace driftwise::cli {
namespace {

constexpr int kUsualCount = 9;  // positions of an axis: a table that fits a terminal

struct MapArguments {
  std::vector<std::string> axes, pose;
  std::string file;
};

// "x": over the fitted domain; "x=0:2.5", "x=0:2.5:11".
v1::MapAxis map_axis_from(const std::string& text) {
  const auto bad = [&text] {
    return Failure{ExitCode::usage, "invalid_argument", "BAD_AXIS",
                   "--axis: found '" + text +
                       "', expected such as x, x=0:2.5 or x=0:2.5:11 (from, to, count)"};
  };
  const auto equals = text.find('=');
  const std::string name = text.substr(0, equals);
  v1::MapAxis axis;
  axis.set_channel(assignment_from(name + "=0").channel());  // its unit, or why there is none
  axis.set_count(kUsualCount);
  if (equals == std::string::npos) return axis;
  const auto first = text.find(':', equals);
  if (first == std::string::npos) throw bad();
  const auto second = text.find(':', first + 1);
  const auto from = number_from(text.substr(equals + 1, first - equals - 1));
  const auto to = number_from(text.substr(first + 1, second - first - 1));
  if (!from || !to) throw bad();
  axis.set_from(*from);
  axis.set_to(*to);
  if (second == std::string::npos) return axis;
  const auto count = number_from(text.substr(second + 1));
  if (!count || *count < 2 || *count > 200 || *count != static_cast<int>(*count)) throw bad();
  axis.set_count(static_cast<int>(*count));
  return axis;
}

double place(const v1::MapAxis& axis, int index) {
  return axis.from() + (axis.to() - axis.from()) * index / (axis.count() - 1);
}

// Highest row first, as on a drawing; * where the pose lies outside the fitted domain, # where it
// lies beyond the soft limits of an axis.
void print_plane(const Console& console, const v1::MapTargetsResponse& map,
                 const v1::MapTargetsResponse::Plane& plane) {
  const auto& h = map.horizontal();
  const auto& v = map.vertical();
  const bool corrects = !plane.correction_nm().empty();
  const auto& values = corrects ? plane.correction_nm() : plane.position_mm();
  console.out << plane.channel() << (corrects ? ": correction in nm" : ": position in mm") << '\n';
  std::vector<Table::Column> columns = {{v.channel() + " \\ " + h.channel(), Align::right}};
  for (int column = 0; column < h.count(); ++column)
    columns.push_back({significant(place(h, column), 4), Align::right});
  Table table(columns);
  for (int row = v.count() - 1; row >= 0; --row) {
    std::vector<Table::Cell> cells = {significant(place(v, row), 4)};
    for (int column = 0; column < h.count(); ++column) {
      const int at = row * h.count() + column;
      cells.push_back((corrects ? signed_fixed(values[at], 1) : fixed(values[at], 6)) +
                      (map.unreachable(at) ? "#"
                       : map.outside(at)   ? "*"
                                           : ""));
    }
    table.add(cells);
  }
  table.print(console.out, console.paint_out());
  const auto [least, most] = std::minmax_element(plane.u90_nm().begin(), plane.u90_nm().end());
  if (least != plane.u90_nm().end())
    console.out << "U90 " << fixed(*least, 1) << " to " << fixed(*most, 1) << " nm\n\n";
}

// One line per pose, for other programs.
std::string map_csv(const v1::MapTargetsResponse& map) {
  const auto& h = map.horizontal();
  const auto& v = map.vertical();
  std::string text = h.channel() + "," + v.channel();
  for (const auto& plane : map.planes()) {
    const std::string symbol = plane.channel().substr(0, plane.channel().rfind('_'));
    text += "," + plane.channel() + "," + symbol + "_correction_nm," + symbol + "_u90_nm";
  }
  text += ",outside,unreachable\n";
  for (int row = 0; row < v.count(); ++row)
    for (int column = 0; column < h.count(); ++column) {
      const int at = row * h.count() + column;
      text += formats::number_text(place(h, column)) + "," + formats::number_text(place(v, row));
      for (const auto& plane : map.planes())
        text +=
            "," + formats::number_text(plane.position_mm(at)) + "," +
            (plane.correction_nm().empty() ? "" : formats::number_text(plane.correction_nm(at))) +
            "," + formats::number_text(plane.u90_nm(at));
      text += map.outside(at) ? ",1" : ",0";
      text += map.unreachable(at) ? ",1\n" : ",0\n";
    }
  return text;
}

ExitCode map_targets(const Session& session, const MapArguments& a) {
  if (a.axes.size() != 2)
    throw Failure{
        ExitCode::usage, "usage", "USAGE",
        "found " + std::to_string(a.axes.size()) + (a.axes.size() == 1 ? " axis" : " axes") +
            ", expected two: --axis x --axis y=0:2.5:11 (a robot of one axis has no plane: "
            "ask for `driftwise target x=1.5`)"};
  v1::MapTargetsRequest request;
  *request.mutable_horizontal() = map_axis_from(a.axes[0]);
  *request.mutable_vertical() = map_axis_from(a.axes[1]);
  *request.mutable_pose() = assignments_from(a.pose);
  const auto map = session.connect().ask(&v1::TargetService::Stub::MapTargets, request, 30);
  if (!a.file.empty()) write_output_file(a.file, map_csv(map));
  if (session.console.json) {
    session.console.print_json(json_from(map));
    return ExitCode::done;
  }
  if (!a.file.empty()) {
    session.console.err << "wrote " << a.file << '\n';
    return ExitCode::done;
  }
  for (const auto& plane : map.planes()) print_plane(session.console, map, plane);
  session.console.out << "model " << map.model_id() << ", conditions of "
                      << clock_text(map.conditions_time()) << " UTC\n";
  if (std::any_of(map.outside().begin(), map.outside().end(), [](bool out) { return out; }))
    session.console.out << "* outside the fitted domain\n";
  if (std::any_of(map.unreachable().begin(), map.unreachable().end(), [](bool out) { return out; }))
    session.console.out << "# not reachable: beyond the soft limits of an axis\n";
  return ExitCode::done;
}

}  // namespace

void add_target_map_command(CLI::App& target, Session& session) {
  auto a = std::make_shared<MapArguments>();
  CLI::App& command =
      add_command(target, session, "map",
                  "The correction over a plane of the workspace, present conditions; moves nothing",
                  [&session, a] { return map_targets(session, *a); });
  command
      .add_option("--axis", a->axes,
                  "two of them: x (over the fitted domain), x=0:2.5 or x=0:2.5:11; the first goes "
                  "to the right")
      ->required()
      ->allow_extra_args(false);
  command.add_option("POSE", a->pose, "everything else: z=1 force=0.768");
  command.add_option("-o,--output", a->file, "write one line per pose to this CSV file instead");
}

}  // namespace driftwise::cli
