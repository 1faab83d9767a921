#include <algorithm>

#include "drivers/simulated/plant/file/hidden_sections.h"
#include "drivers/simulated/plant/file/plant_sections.h"
#include "drivers/simulated/plant/file/robot_sections.h"

namespace driftwise::simulated {
namespace {

WarmLength warm_length(Fields f, const Materials& materials,
                       const std::vector<PartParameters>& parts) {
  WarmLength length{.mm = f.within("length_mm", -1000, 1000),
                    .expansion_per_k = expansion_named(f, "material", materials),
                    .parts = parts_named(f, "parts", parts)};
  f.finish();
  return length;
}

ScrewParameters screw_section(Fields f, const Materials& materials, MinAngleParameters& plant,
                              std::size_t index) {
  ScrewParameters screw{.radius_mm = f.within("radius_mm", 10, 500),
                        .azimuth_deg = f.within("azimuth_deg", -360, 360),
                        .leg_mm = f.within("leg_mm", 10, 500),
                        .lean_mrad = {},
                        .scale_ppm = f.within("scale_ppm", -1000, 1000)};
  const auto lean = f.numbers("lean_mrad", 2);
  screw.lean_mrad = {lean[0], lean[1]};
  plant.end_effector.height[index] = warm_length(f.table("height"), materials, plant.parts);
  f.finish();
  return screw;
}

void end_effector_section(Fields f, const Materials& materials, MinAngleParameters& plant) {
  plant.end_effector.shortening_factor = f.within("shortening_factor", 0, 0.7);
  plant.end_effector.cube_below_mm = f.within("cube_below_mm", 0, 200);
  plant.end_effector.x = warm_length(f.table("x"), materials, plant.parts);
  plant.end_effector.y = warm_length(f.table("y"), materials, plant.parts);
  f.finish();
}

TouchProbeParameters touch_probe_section(Fields f) {
  TouchProbeParameters probe{.friction_um = f.within("friction_um", 0, 100),
                             .lean_deg = f.within("lean_deg", -45, 45),
                             .range_mm = f.within("range_mm", 0.1, 100),
                             .noise_nm = f.not_negative("noise_nm")};
  f.finish();
  return probe;
}

InclinometerParameters inclinometer_section(Fields f) {
  InclinometerParameters level{.step_deg = f.positive("step_deg"),
                               .noise_arcsec = f.not_negative("noise_arcsec"),
                               .range_deg = f.within("range_deg", 0.1, 90)};
  f.finish();
  return level;
}

void min_angle_beams(Fields fields, Fields common, const Materials& materials,
                     MinAngleParameters& plant) {
  const InterferometerParameters device = interferometer_section(common, plant.parts);
  common.finish();
  const std::array<std::string, 3> names{"x", "y", "z"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    Fields one = fields.table(names[i]);
    auto& beam = plant.beams[i];
    beam.offset_u_mm = one.within("offset_u_mm", -15, 15);
    beam.offset_v_mm = one.within("offset_v_mm", -15, 15);
    plant.interferometers.push_back(device);
    plant.interferometers.back().dead_path_mm = one.within("dead_path_mm", 1, 2000);
    Fields pieces = one.table("device");
    for (const auto& name : pieces.table_names())
      beam.device.push_back(warm_length(pieces.table(name), materials, plant.parts));
    one.finish();
  }
  plant.tilt_limit_arcsec = fields.positive("tilt_limit_arcsec");
  fields.finish();
}

void min_angle_collimator(Fields f, MinAngleParameters& plant) {
  plant.collimator.range_arcsec = f.positive("range_arcsec");
  plant.collimator.noise_arcsec = f.not_negative("noise_arcsec");
  plant.collimator.noise_s = f.positive("noise_s");
  plant.mirror_arcsec_per_k = f.within("mirror_arcsec_per_k", -100, 100);
  f.finish();
}

}  // namespace

MinAngleParameters min_angle_sections(Fields root) {
  MinAngleParameters plant;
  Fields head = root.table("plant");
  head.text("kind");
  const Materials materials = cell_sections(root, head, plant);
  head.finish();
  Fields screws = root.table("screw");
  for (std::size_t i = 0; i < kScrews; ++i)
    plant.screws[i] = screw_section(screws.table(std::to_string(i + 1)), materials, plant, i);
  screws.finish();
  end_effector_section(root.table("end_effector"), materials, plant);
  plant.probe = touch_probe_section(root.table("touch_probe"));
  plant.inclinometer = inclinometer_section(root.table("inclinometer"));
  min_angle_beams(root.table("beam"), root.table("interferometer"), materials, plant);
  min_angle_collimator(root.table("collimator"), plant);

  Fields axis = root.table("axis");
  plant.axes.assign(kScrews, axis_section(axis));
  const auto motors = parts_named(axis, "motor_parts", plant.parts);
  if (motors.size() != kScrews) axis.fail("motor_parts", "expected three parts");
  Fields stabiliser = root.table("stabiliser");
  plant.stabilisers.assign(kScrews, stabiliser_section(stabiliser));
  const auto supports = parts_named(stabiliser, "parts", plant.parts);
  const auto sinks = parts_named(stabiliser, "sink_parts", plant.parts);
  if (supports.size() != kScrews) stabiliser.fail("parts", "expected three parts");
  if (sinks.size() != kScrews) stabiliser.fail("sink_parts", "expected three parts");
  for (std::size_t i = 0; i < kScrews; ++i) {
    plant.axes[i].motor_part = motors[i];
    plant.stabilisers[i].part = supports[i];
    plant.stabilisers[i].sink_part = sinks[i];
  }
  axis.finish();
  stabiliser.finish();
  voltage_sections(root, plant);
  hidden_sections(root, materials, plant);
  root.finish();
  return plant;
}

}  // namespace driftwise::simulated
