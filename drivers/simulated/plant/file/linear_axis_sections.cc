#include <cmath>
#include <iomanip>
#include <sstream>

#include "drivers/simulated/plant/file/hidden_sections.h"
#include "drivers/simulated/plant/file/plant_sections.h"
#include "drivers/simulated/plant/file/robot_sections.h"

namespace driftwise::simulated {
namespace {

std::vector<LoopParameters> loop_section(Fields fields, const std::vector<PartParameters>& parts) {
  std::vector<LoopParameters> loop;
  for (const auto& name : fields.table_names()) {
    Fields one = fields.table(name);
    LoopParameters piece{.name = name};
    piece.parts = parts_named(one, "parts", parts);
    const std::string member = one.text("member");
    if (member != "robot" && member != "device") {
      one.fail("member", "found '" + member + "', expected robot or device");
    }
    piece.robot = member == "robot";
    piece.length_mm = one.number("length_mm");
    piece.expansion_per_k = parts[static_cast<std::size_t>(piece.parts.front())].expansion_per_k;
    one.finish();
    loop.push_back(std::move(piece));
  }
  return loop;
}

BendingParameters bending_section(Fields fields, const Materials& materials,
                                  const std::vector<PartParameters>& parts) {
  BendingParameters bending{.top = part_named(fields, "top", parts),
                            .bottom = part_named(fields, "bottom", parts),
                            .expansion_per_k = expansion_named(fields, "material", materials),
                            .node_distance_mm = fields.positive("node_distance_mm"),
                            .span_mm = fields.number("span_mm"),
                            .height_mm = fields.number("height_mm")};
  fields.finish();
  return bending;
}

ParallelogramParameters parallelogram_section(Fields fields, const Materials& materials,
                                              const std::vector<PartParameters>& parts) {
  ParallelogramParameters p{.left_part = part_named(fields, "left_part", parts),
                            .right_part = part_named(fields, "right_part", parts),
                            .expansion_per_k = expansion_named(fields, "material", materials),
                            .left_length_mm = fields.within("left_length_mm", 10, 1000),
                            .right_length_mm = fields.within("right_length_mm", 10, 1000),
                            .shortening_factor = fields.within("shortening_factor", 0.4, 0.7),
                            .spacing_mm = fields.positive("spacing_mm"),
                            .beam_above_scale_mm = fields.number("beam_above_scale_mm"),
                            .mirror_tilt_mrad = fields.within("mirror_tilt_mrad", -50, 50),
                            .beam_yaw_mrad = fields.within("beam_yaw_mrad", -50, 50)};
  p.scale_part = part_index(fields, "", "scale", parts);
  p.scale_expansion_per_k = parts[static_cast<std::size_t>(p.scale_part)].expansion_per_k;
  fields.finish();
  return p;
}

std::string number_text(double value) {
  std::ostringstream out;
  out << std::setprecision(9) << value;
  return out.str();
}

// The pieces lead from the head to the mirror through metal; air is the straight way.
void check_closure(const Fields& root, const LinearAxisParameters& plant) {
  double sum_mm = 0;
  for (const auto& piece : plant.loop) sum_mm += piece.length_mm;
  if (std::abs(sum_mm - plant.interferometer().dead_path_mm) > 1e-6) {
    root.fail("loop", "the lengths sum to " + number_text(sum_mm) +
                          " mm, expected interferometer.dead_path_mm = " +
                          number_text(plant.interferometer().dead_path_mm) + ": a loop closes");
  }
}

}  // namespace

LinearAxisParameters linear_axis_sections(Fields root) {
  LinearAxisParameters plant;
  Fields head = root.table("plant");
  head.text("kind");
  const Materials materials = cell_sections(root, head, plant);
  head.finish();
  plant.loop = loop_section(root.table("loop"), plant.parts);
  plant.bending = bending_section(root.table("bending"), materials, plant.parts);
  plant.parallelogram = parallelogram_section(root.table("parallelogram"), materials, plant.parts);
  Fields axis = root.table("axis");
  plant.axes = {axis_section(axis)};
  plant.axes.front().motor_part = part_named(axis, "motor_part", plant.parts);
  axis.finish();
  Fields interferometer = root.table("interferometer");
  plant.interferometers = {interferometer_section(interferometer, plant.parts)};
  plant.interferometers.front().dead_path_mm = interferometer.not_negative("dead_path_mm");
  interferometer.finish();
  Fields stabiliser = root.table("stabiliser");
  plant.stabilisers = {stabiliser_section(stabiliser)};
  plant.stabilisers.front().part = part_named(stabiliser, "part", plant.parts);
  plant.stabilisers.front().sink_part = part_named(stabiliser, "sink_part", plant.parts);
  stabiliser.finish();
  voltage_sections(root, plant);
  hidden_sections(root, materials, plant);
  root.finish();
  check_closure(root, plant);
  return plant;
}

}  // namespace driftwise::simulated
