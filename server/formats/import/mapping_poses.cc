#include "server/formats/import/mapping_poses.h"

#include "server/core/reasons.h"
#include "server/core/units.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

using Rows = std::vector<std::vector<double>>;

void read_convention(TomlReader& reader, const char* key, RotationConvention& out) {
  std::string name(to_string(out));
  reader.text(key, name);
  const auto convention = rotation_convention(name);
  if (convention)
    out = *convention;
  else
    reader.refuse(key, reasons::kOutOfRange, convention.error().message);
}

// Position channels measure lengths, rotation channels angles; three of them or none.
void read_triple(TomlReader& reader, const char* key, std::vector<std::string>& out,
                 bool (*is_kind)(std::string_view), const char* example, Need need) {
  std::vector<std::string> names;
  reader.texts(key, names, need);
  if (!reader.has(key)) return;
  bool good = names.size() == 3;
  for (const auto& name : names) {
    const auto channel = parse_channel(name);
    good = good && channel && is_kind(channel->unit);
  }
  if (good)
    out = std::move(names);
  else
    reader.refuse(key, reasons::kBadChannel,
                  "expected three channels such as " + std::string(example));
}

void matrix_transform(TomlReader& reader, const Rows& rows, RigidTransform& out) {
  const bool four = rows.size() == 4 && rows.front().size() == 4;
  const bool three = rows.size() == 3 && rows.front().size() == 4;
  if (!four && !three)
    return reader.refuse("matrix", reasons::kOutOfRange,
                         "found " + std::to_string(rows.size()) +
                             " rows, expected 4 (or the first 3) of 4 numbers each");
  if (four && rows[3] != std::vector<double>{0, 0, 0, 1})
    return reader.refuse("matrix", reasons::kOutOfRange, "expected 0, 0, 0, 1 in the last row");
  Eigen::Matrix3d matrix;
  for (int i = 0; i < 3; ++i) {
    const auto& row = rows[static_cast<std::size_t>(i)];
    matrix.row(i) << row[0], row[1], row[2];
    out.translation_mm(i) = row[3];
  }
  const auto rotation = nearest_rotation(matrix);
  if (!rotation) return reader.refuse("matrix", reasons::kNotARotation, rotation.error().message);
  out.rotation = *rotation;
}

void read_transform(const toml::table* table, const std::string& place, TomlProblem& problem,
                    RigidTransform& out) {
  if (!table) return;
  TomlReader reader(*table, place, problem);
  Rows rows;
  std::vector<double> translation_mm(3, 0), rotation_deg(3, 0);
  auto convention = RotationConvention::xyz_fixed;
  bool inverse = false;
  reader.matrix("matrix", rows);
  reader.numbers("translation_mm", translation_mm, 3);
  reader.numbers("rotation_deg", rotation_deg, 3);
  read_convention(reader, "convention", convention);
  reader.truth("inverse", inverse);
  if (reader.has("matrix") && (reader.has("translation_mm") || reader.has("rotation_deg")))
    reader.refuse("matrix", reasons::kBadRule,
                  "expected either a matrix or translation_mm and rotation_deg");
  if (!rows.empty()) {
    matrix_transform(reader, rows, out);
  } else {
    out.translation_mm = Eigen::Vector3d::Map(translation_mm.data());
    out.rotation =
        rotation_matrix(convention, Eigen::Vector3d::Map(rotation_deg.data()) * kRadPerDeg);
  }
  if (inverse) out = out.inverse();
  reader.finish();
}

}  // namespace

void read_pose(const toml::table& table, const std::string& place, TomlProblem& problem,
               PoseRule& out) {
  TomlReader reader(table, place, problem);
  read_triple(reader, "position", out.position, is_length, "x_mm, y_mm, z_mm", Need::required);
  read_triple(reader, "rotation", out.rotation, is_angle, "rx_deg, ry_deg, rz_deg", Need::optional);
  out.into_position = out.position;
  out.into_rotation = out.rotation;
  read_triple(reader, "into_position", out.into_position, is_length, "x_mm, y_mm, z_mm",
              Need::optional);
  read_triple(reader, "into_rotation", out.into_rotation, is_angle, "rx_deg, ry_deg, rz_deg",
              Need::optional);
  read_convention(reader, "convention", out.convention);
  out.into_convention = out.convention;
  read_convention(reader, "into_convention", out.into_convention);
  read_transform(reader.table("frame"), place + ", frame", problem, out.frame);
  read_transform(reader.table("tool"), place + ", tool", problem, out.tool);
  if (out.rotation.empty() && (reader.has("tool") || reader.has("into_rotation")))
    reader.refuse("rotation", reasons::kBadRule,
                  "expected the pose's three angles: a tool cannot be taken off without them");
  reader.finish();
}

}  // namespace driftwise::formats
