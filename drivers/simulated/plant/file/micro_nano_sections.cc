#include <algorithm>

#include "drivers/simulated/plant/file/delta_sections.h"
#include "drivers/simulated/plant/file/hidden_sections.h"
#include "drivers/simulated/plant/file/plant_sections.h"
#include "drivers/simulated/plant/file/robot_sections.h"

namespace driftwise::simulated {
namespace {

DeltaParameters delta_section(Fields f, const Materials& materials,
                              const std::vector<PartParameters>& parts) {
  DeltaParameters d = flexure_delta_section(f, materials, parts);
  const auto azimuth = f.numbers("azimuth_deg", kArms);
  std::copy(azimuth.begin(), azimuth.end(), d.azimuth_deg.begin());
  d.column_radius_mm = f.within("column_radius_mm", 10, 1000);
  if (d.arm_mm <= std::abs(d.column_radius_mm - d.platform_radius_mm) + 5) {
    f.fail("arm_mm", "is too short to reach from column_radius_mm to platform_radius_mm");
  }
  f.finish();
  return d;
}

// A part that is there once per arm is named without its number.
void carriage_sections(Fields fields, const Materials& materials,
                       const std::vector<PartParameters>& parts, DeltaParameters& delta) {
  const auto known = [&](const std::string& name) {
    return std::any_of(parts.begin(), parts.end(),
                       [&](const PartParameters& part) { return part.name == name; });
  };
  for (const auto& name : fields.table_names()) {
    Fields one = fields.table(name);
    const std::string axis = one.text("axis");
    if (axis != "outwards" && axis != "upwards") {
      one.fail("axis", "found '" + axis + "', expected outwards or upwards");
    }
    const auto part_names = one.texts("parts");
    WarmLength length{.mm = one.within("length_mm", -1000, 1000),
                      .expansion_per_k = expansion_named(one, "material", materials),
                      .parts = {}};
    one.finish();
    for (std::size_t i = 0; i < kArms; ++i) {
      length.parts.clear();
      for (const auto& part : part_names) {
        const std::string own = part + "_" + std::to_string(i + 1);
        length.parts.push_back(part_index(one, "parts", known(own) ? own : part, parts));
      }
      (axis == "outwards" ? delta.outwards : delta.upwards)[i].push_back(length);
    }
  }
  if (delta.upwards.front().empty()) fields.fail("", "found no upwards length, expected a column");
}

LoadParameters load_section(Fields f) {
  LoadParameters load{.max_n = f.within("max_n", 0.001, 1000),
                      .weight_n = f.positive("weight_n"),
                      .seconds_per_weight = f.within("seconds_per_weight", 0.01, 100),
                      .swing_share = f.within("swing_share", 0, 0.5),
                      .swing_s = f.positive("swing_s"),
                      .swing_period_s = f.positive("swing_period_s"),
                      .rest_s = f.not_negative("rest_s"),
                      .g_declared_m_s2 = f.within("g_declared_m_s2", 9, 10),
                      .g_here_m_s2 = f.within("g_here_m_s2", 9, 10),
                      .pan_n = f.not_negative("pan_n"),
                      .friction = f.within("friction", 0, 0.5),
                      .wire_n_mm = f.positive("wire_n_mm"),
                      .attach_mm = vector_of(f, "attach_mm"),
                      .pulley_height_mm = f.within("pulley_height_mm", 10, 10000)};
  f.finish();
  return load;
}

}  // namespace

MicroNanoParameters micro_nano_sections(Fields root) {
  MicroNanoParameters plant;
  Fields head = root.table("plant");
  head.text("kind");
  plant.machine = static_cast<std::uint64_t>(head.whole("machine", 0, 2'000'000'000));
  const Materials materials = cell_sections(root, head, plant);
  head.finish();
  plant.delta = delta_section(root.table("delta"), materials, plant.parts);
  carriage_sections(root.table("carriage"), materials, plant.parts, plant.delta);
  plant.tolerance = tolerance_section(root.table("tolerance"));
  plant.cube = cube_section(root.table("cube"));
  // The z head looks down from above: what it shows is turned, so that + is upwards.
  beam_sections(root.table("beam"), root.table("interferometer"), {1, 1, -1}, plant, plant.beams);
  loop_sections(root.table("loop"), materials, plant.parts, plant.beams);
  Fields optics = root.table("optics");
  plant.optics = optics_section(optics);
  plant.optics.fold_height_mm = optics.within("fold_height_mm", 1, 1000);
  plant.optics.fold_span_mm = optics.within("fold_span_mm", 10, 1000);
  optics.finish();
  plant.collimator = collimator_section(root.table("collimator"), plant.parts);
  plant.load = load_section(root.table("load"));

  Fields axis = root.table("axis");
  plant.axes.assign(kArms, axis_section(axis));
  Fields stabiliser = root.table("stabiliser");
  plant.stabilisers.assign(kArms, stabiliser_section(stabiliser));
  const auto motors = parts_named(axis, "motor_parts", plant.parts);
  const auto supports = parts_named(stabiliser, "parts", plant.parts);
  const auto sinks = parts_named(stabiliser, "sink_parts", plant.parts);
  if (motors.size() != kArms) axis.fail("motor_parts", "expected three parts");
  if (supports.size() != kArms) stabiliser.fail("parts", "expected three parts");
  if (sinks.size() != kArms) stabiliser.fail("sink_parts", "expected three parts");
  for (std::size_t i = 0; i < kArms; ++i) {
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
