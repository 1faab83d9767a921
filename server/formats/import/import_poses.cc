#include "server/formats/import/import_poses.h"

#include <array>

#include "server/core/unit_conversion.h"

namespace driftwise::formats {
namespace {

struct Triple {
  std::array<std::size_t, 3> columns{};    // of the dataset
  std::array<UnitConversion, 3> to, from;  // channel's unit -> mm or rad, and back
};

std::size_t column_named(Dataset& dataset, const std::string& name) {
  for (std::size_t i = 0; i < dataset.columns.size(); ++i)
    if (dataset.columns[i].channel.name() == name) return i;
  dataset.columns.push_back({*parse_channel(name), std::vector<double>(dataset.rows, kMissing)});
  return dataset.columns.size() - 1;
}

// The mapping file's reader has seen to it that names are channels of the right kind.
Triple find_triple(Dataset& dataset, const std::vector<std::string>& names, const char* unit) {
  Triple out;
  for (std::size_t i = 0; i < 3; ++i) {
    out.columns[i] = column_named(dataset, names[i]);
    const std::string& own = dataset.columns[out.columns[i]].channel.unit;
    out.to[i] = *unit_conversion(own, unit);
    out.from[i] = *unit_conversion(unit, own);
  }
  return out;
}

Eigen::Vector3d read_triple_at(const Dataset& dataset, const Triple& triple, std::size_t row) {
  Eigen::Vector3d out;
  for (std::size_t i = 0; i < 3; ++i)
    out(static_cast<Eigen::Index>(i)) =
        triple.to[i](dataset.columns[triple.columns[i]].values[row]);
  return out;
}

void write_triple_at(Dataset& dataset, const Triple& triple, std::size_t row,
                     const Eigen::Vector3d& value) {
  for (std::size_t i = 0; i < 3; ++i)
    dataset.columns[triple.columns[i]].values[row] =
        triple.from[i](value(static_cast<Eigen::Index>(i)));
}

}  // namespace

void apply_pose(const PoseRule& rule, Dataset& dataset) {
  const bool turns = !rule.rotation.empty();
  const Triple position = find_triple(dataset, rule.position, "mm");
  const Triple into_position = find_triple(dataset, rule.into_position, "mm");
  const Triple rotation = turns ? find_triple(dataset, rule.rotation, "rad") : Triple{};
  const Triple into_rotation = turns ? find_triple(dataset, rule.into_rotation, "rad") : Triple{};
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    RigidTransform measured;
    measured.translation_mm = read_triple_at(dataset, position, row);
    Eigen::Vector3d angles_rad = Eigen::Vector3d::Zero();
    if (turns) angles_rad = read_triple_at(dataset, rotation, row);
    const bool whole = measured.translation_mm.allFinite() && angles_rad.allFinite();
    if (!whole) {
      const Eigen::Vector3d nothing = Eigen::Vector3d::Constant(kMissing);
      write_triple_at(dataset, into_position, row, nothing);
      if (turns) write_triple_at(dataset, into_rotation, row, nothing);
      continue;
    }
    measured.rotation = rotation_matrix(rule.convention, angles_rad);
    const RigidTransform wanted = rule.frame * measured * rule.tool;
    write_triple_at(dataset, into_position, row, wanted.translation_mm);
    if (turns)
      write_triple_at(dataset, into_rotation, row,
                      rotation_angles_rad(rule.into_convention, wanted.rotation));
  }
}

}  // namespace driftwise::formats
