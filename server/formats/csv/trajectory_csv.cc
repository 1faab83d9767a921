#include "server/formats/csv/trajectory_csv.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/csv/csv_text.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

enum class TrajectoryColumn : std::uint8_t { coordinate, set, line, zero, force, dwell };

// The columns that are no coordinates, or none for a name that no trajectory has.
std::optional<TrajectoryColumn> kind_from(const std::string& name) {
  if (name == "set") return TrajectoryColumn::set;
  if (name == "line") return TrajectoryColumn::line;
  if (name == "zero") return TrajectoryColumn::zero;
  if (name == "force_N") return TrajectoryColumn::force;
  if (name == "dwell_s") return TrajectoryColumn::dwell;
  const auto channel = parse_robot_channel(name);
  if (!channel) return std::nullopt;
  const auto symbol = without_robot(channel->symbol);
  const bool is_rotation = is_pose_symbol(symbol) && symbol.front() == 'r';
  const bool has_unit =
      is_rotation ? channel->unit == "arcsec" || channel->unit == "deg" : channel->unit == "mm";
  if (has_unit && (is_motor_symbol(symbol) || is_pose_symbol(symbol)))
    return TrajectoryColumn::coordinate;
  return std::nullopt;
}

bool is_motor_column(const Channel& channel) {
  return is_motor_symbol(without_robot(channel.symbol));
}

// A column of the file: its kind, and what its numbers are multiplied by.
struct TrajectoryField {
  TrajectoryColumn kind;
  double factor = 1;
  std::string unit;  // of a coordinate, in the file
};

tl::unexpected<Error> bad_header(Reason reason, const CsvHeader& header,
                                 const std::string& file_name, const std::string& sentence) {
  return fail(ErrorCode::invalid_argument, reason, at_line(file_name, header.line) + sentence);
}

Result<std::vector<TrajectoryField>> sort_columns(const CsvHeader& header,
                                                  const std::string& file_name,
                                                  std::vector<Channel>& coordinates) {
  constexpr double kArcsecPerDeg = 3600;
  std::vector<TrajectoryField> kinds;
  for (const auto& name : header.names) {
    const auto kind = kind_from(name);
    if (!kind)
      return bad_header(reasons::kUnknownColumn, header, file_name,
                        "column " + std::to_string(kinds.size() + 1) + ": found " + shown(name) +
                            ", expected q1_mm, q2_mm, ... or x_mm, y_mm, z_mm, rx_arcsec, "
                            "ry_arcsec, rz_arcsec (or _deg), with a robot's id before it in a "
                            "cell with several (ma.q1_mm), and set, line, zero, force_N, dwell_s");
    auto& column = kinds.emplace_back(TrajectoryField{*kind, 1, {}});
    if (*kind != TrajectoryColumn::coordinate) continue;
    auto channel = *parse_robot_channel(name);
    column.unit = channel.unit;
    if (channel.unit == "deg") {
      channel.unit = "arcsec";
      column.factor = kArcsecPerDeg;
    }
    if (std::ranges::find(coordinates, channel) != coordinates.end())
      return bad_header(reasons::kDuplicateColumn, header, file_name,
                        "column " + std::to_string(kinds.size()) + ": found " + shown(name) +
                            ", which is there already, expected each coordinate once");
    coordinates.push_back(std::move(channel));
  }
  if (coordinates.empty())
    return bad_header(reasons::kNoCoordinates, header, file_name,
                      "found no coordinates, expected q1_mm, q2_mm, ... or x_mm, y_mm, z_mm");
  for (const auto& channel : coordinates)
    if (is_motor_column(channel) != is_motor_column(coordinates.front()))
      return bad_header(reasons::kMixedCoordinates, header, file_name,
                        "found " + coordinates.front().name() + " and " + channel.name() +
                            ", expected motor coordinates only or pose coordinates only");
  return kinds;
}

// Reads the fields of one row, and checks what a row alone can show.
Result<TrajectoryPoint> read_point(CsvRows& rows, const std::vector<TrajectoryField>& kinds) {
  TrajectoryPoint point;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    double number = 0;
    bool truth = false;
    bool good = true;
    switch (kinds[i].kind) {
      case TrajectoryColumn::coordinate:
        good = rows.number(number);
        if (good && is_missing(number))
          return tl::unexpected(
              rows.problem(reasons::kMissingCoordinate, i,
                           "found nothing, expected a number in " + kinds[i].unit));
        point.target.push_back(number * kinds[i].factor);
        break;
      case TrajectoryColumn::set:
        good = rows.set_is_validation(truth);
        point.set = truth ? PointSet::validation : PointSet::calibration;
        break;
      case TrajectoryColumn::line:
        good = rows.integer(point.line);
        break;
      case TrajectoryColumn::zero:
        good = rows.flag(point.zero);
        break;
      case TrajectoryColumn::force:
        good = rows.number(number);
        if (!is_missing(number)) point.force_n = number;
        break;
      case TrajectoryColumn::dwell:
        good = rows.number(number);
        if (good && (number < 0 || number > kMostDwell_s))
          return tl::unexpected(rows.problem(reasons::kBadDwell, i,
                                             "found " + number_text(number) + ", expected 0 to " +
                                                 number_text(kMostDwell_s) + " s (a week)"));
        if (!is_missing(number)) point.dwell_s = number;
        break;
    }
    if (!good) return tl::unexpected(rows.error());
  }
  return point;
}

std::size_t first_column(const std::vector<TrajectoryField>& kinds, TrajectoryColumn kind) {
  return static_cast<std::size_t>(std::ranges::find(kinds, kind, &TrajectoryField::kind) -
                                  kinds.begin());
}

}  // namespace

Result<Trajectory> read_trajectory_csv(std::string_view text, const std::string& file_name) {
  DRIFTWISE_TRY(const auto header, read_csv_header(text, file_name));
  Trajectory trajectory;
  DRIFTWISE_TRY(const auto kinds, sort_columns(header, file_name, trajectory.coordinates));

  // A trajectory has thousands of rows, not millions: one piece.
  const CsvChunk whole{header.rows, header.line, 0, 0};
  CsvRows rows(header, file_name, whole);
  while (rows.next_row()) {
    DRIFTWISE_TRY(auto point, read_point(rows, kinds));
    if (!trajectory.points.empty() && point.line < trajectory.points.back().line)
      return tl::unexpected(
          rows.problem(reasons::kLineDecreases, first_column(kinds, TrajectoryColumn::line),
                       "found " + std::to_string(point.line) + " after " +
                           std::to_string(trajectory.points.back().line) +
                           ", expected the points of one line to follow one another"));
    if (point.zero && !std::ranges::all_of(point.target, [](double value) { return value == 0; }))
      return tl::unexpected(
          rows.problem(reasons::kZeroNotAtZero, first_column(kinds, TrajectoryColumn::zero),
                       "found 1 with coordinates that are not all 0: a return to zero goes to 0"));
    if (trajectory.points.size() >= kMostTrajectoryRows)
      return tl::unexpected(rows.problem(
          reasons::kTooManyRows, kinds.size(),
          "found more than " + std::to_string(kMostTrajectoryRows) + " rows: split the plan"));
    trajectory.points.push_back(std::move(point));
  }
  if (rows.failed()) return tl::unexpected(rows.error());
  if (trajectory.points.empty())
    return bad_header(reasons::kNoRows, header, file_name,
                      "found a header row and nothing after it, expected one row per point");
  return trajectory;
}

std::string write_trajectory_csv(const Trajectory& trajectory) {
  const bool has_force =
      std::ranges::any_of(trajectory.points, [](const auto& p) { return p.force_n.has_value(); });
  const bool has_dwell =
      std::ranges::any_of(trajectory.points, [](const auto& p) { return p.dwell_s.has_value(); });
  std::string out;
  for (const auto& channel : trajectory.coordinates) out += channel.name() + ",";
  out += "set,line,zero";
  if (has_force) out += ",force_N";
  if (has_dwell) out += ",dwell_s";
  out += '\n';
  for (const auto& point : trajectory.points) {
    for (const double value : point.target) append_number(out, value), out += ',';
    out += point.set == PointSet::validation ? "validation," : "calibration,";
    append_number(out, point.line);
    out += point.zero ? ",1" : ",0";
    if (has_force) out += ',', append_number(out, point.force_n.value_or(kMissing));
    if (has_dwell) out += ',', append_number(out, point.dwell_s.value_or(kMissing));
    out += '\n';
  }
  return out;
}

}  // namespace driftwise::formats
