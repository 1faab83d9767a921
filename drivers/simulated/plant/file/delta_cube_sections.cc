#include "drivers/simulated/plant/file/delta_sections.h"
#include "drivers/simulated/plant/file/hidden_sections.h"
#include "drivers/simulated/plant/file/robot_sections.h"

namespace driftwise::simulated {
namespace {

// Carriers of the carriage of each axis, from the robot's middle outwards; [carriage.1.*] to
// [carriage.3.*].
void outward_sections(Fields fields, const Materials& materials, DeltaCubeParameters& plant) {
  for (std::size_t i = 0; i < kArms; ++i) {
    Fields axis = fields.table(std::to_string(i + 1));
    for (const auto& name : axis.table_names()) {
      Fields one = axis.table(name);
      plant.delta.outwards[i].push_back(
          {.mm = one.within("length_mm", -1000, 1000),
           .expansion_per_k = expansion_named(one, "material", materials),
           .parts = parts_named(one, "parts", plant.parts)});
      one.finish();
    }
    axis.finish();
  }
  fields.finish();
}

}  // namespace

DeltaCubeParameters delta_cube_sections(Fields root) {
  DeltaCubeParameters plant;
  Fields head = root.table("plant");
  head.text("kind");
  plant.machine = static_cast<std::uint64_t>(head.whole("machine", 0, 2'000'000'000));
  const Materials materials = cell_sections(root, head, plant);
  head.finish();
  Fields delta = root.table("delta");
  plant.delta = flexure_delta_section(delta, materials, plant.parts);
  delta.finish();
  outward_sections(root.table("carriage"), materials, plant);
  plant.tolerance = tolerance_section(root.table("tolerance"));
  plant.cube = cube_section(root.table("cube"));
  beam_sections(root.table("beam"), root.table("interferometer"), {1, 1, 1}, plant, plant.beams);
  loop_sections(root.table("loop"), materials, plant.parts, plant.beams);
  Fields optics = root.table("optics");
  plant.optics = optics_section(optics);
  optics.finish();
  plant.collimator = collimator_section(root.table("collimator"), plant.parts);

  Fields axis = root.table("axis");
  plant.axes.assign(kArms, axis_section(axis));
  const auto motors = parts_named(axis, "motor_parts", plant.parts);
  if (motors.size() != kArms) axis.fail("motor_parts", "expected three parts");
  for (std::size_t i = 0; i < kArms; ++i) plant.axes[i].motor_part = motors[i];
  axis.finish();
  // One regulator holds the box.
  Fields stabiliser = root.table("stabiliser");
  plant.stabilisers.assign(1, stabiliser_section(stabiliser));
  plant.stabilisers.front().part = part_named(stabiliser, "part", plant.parts);
  plant.stabilisers.front().sink_part = part_named(stabiliser, "sink_part", plant.parts);
  stabiliser.finish();
  Fields box = root.table("box");
  plant.box_air_part = part_named(box, "air_part", plant.parts);
  plant.box_open_flow_m3_h = box.within("open_flow_m3_h", 0, 10000);
  box.finish();
  voltage_sections(root, plant);
  hidden_sections(root, materials, plant);
  root.finish();
  return plant;
}

}  // namespace driftwise::simulated
