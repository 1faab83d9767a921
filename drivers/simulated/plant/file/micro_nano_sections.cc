#include <algorithm>

#include "drivers/simulated/plant/file/hidden_sections.h"
#include "drivers/simulated/plant/file/plant_sections.h"
#include "drivers/simulated/plant/file/robot_sections.h"

namespace driftwise::simulated {
namespace {

Vec3 vector_of(Fields& fields, std::string_view key) {
  const auto numbers = fields.numbers(key, 3);
  return {numbers[0], numbers[1], numbers[2]};
}

DeltaParameters delta_section(Fields f, const Materials& materials,
                              const std::vector<PartParameters>& parts) {
  DeltaParameters d;
  const auto azimuth = f.numbers("azimuth_deg", kArms);
  std::copy(azimuth.begin(), azimuth.end(), d.azimuth_deg.begin());
  d.column_radius_mm = f.within("column_radius_mm", 10, 1000);
  d.platform_radius_mm = f.within("platform_radius_mm", 1, 1000);
  d.arm_mm = f.within("arm_mm", 10, 1000);
  if (d.arm_mm <= std::abs(d.column_radius_mm - d.platform_radius_mm) + 5) {
    f.fail("arm_mm", "is too short to reach from column_radius_mm to platform_radius_mm");
  }
  d.pair_spacing_mm = f.within("pair_spacing_mm", 1, 500);
  d.arm_expansion_per_k = expansion_named(f, "arm_material", materials);
  d.platform_expansion_per_k = expansion_named(f, "platform_material", materials);
  d.scale_expansion_per_k = expansion_named(f, "scale_material", materials);
  d.leg_mm = f.within("leg_mm", 10, 1000);
  d.leg_spacing_mm = f.within("leg_spacing_mm", 1, 1000);
  d.shortening_factor = f.within("shortening_factor", 0.4, 0.7);
  d.neutral_mm = f.within("neutral_mm", -5, 5);
  d.hinges_per_bar = f.whole("hinges_per_bar", 1, 8);
  d.hinge = {.thickness_mm = f.within("hinge_thickness_mm", 0.01, 2),
             .width_mm = f.within("hinge_width_mm", 0.1, 100),
             .length_mm = f.within("hinge_length_mm", 0.1, 50),
             .youngs_gpa = f.within("youngs_gpa", 1, 1000)};
  d.bar_section_mm2 = f.within("bar_section_mm2", 0.1, 1e4);
  d.moving_kg = f.within("moving_kg", 0.001, 10);
  f.finish();
  d.platform_part = part_index(f, "", "platform", parts);
  for (std::size_t i = 0; i < kArms; ++i) {
    const std::string number = std::to_string(i + 1);
    d.arm_part[i] = part_index(f, "", "arms_" + number, parts);
    d.scale_part[i] = part_index(f, "", "stage_" + number, parts);
  }
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

ToleranceParameters tolerance_section(Fields f) {
  ToleranceParameters t{.column_mm = f.within("column_mm", 0, 1),
                        .guide_mrad = f.within("guide_mrad", 0, 20),
                        .mount_mrad = f.within("mount_mrad", 0, 20),
                        .skew_mrad = f.within("skew_mrad", 0, 20),
                        .joint_mm = f.within("joint_mm", 0, 1),
                        .bar_mm = f.within("bar_mm", 0, 1),
                        .leg_mm = f.within("leg_mm", 0, 1),
                        .scale_ppm = f.within("scale_ppm", 0, 1000)};
  f.finish();
  return t;
}

CubeParameters cube_section(Fields f) {
  CubeParameters cube{.centre_mm = vector_of(f, "centre_mm"),
                      .edge_mm = f.within("edge_mm", 1, 200),
                      .flatness_nm = f.within("flatness_nm", 0, 1e4),
                      .facet_arcsec = f.within("facet_arcsec", 0, 600)};
  f.finish();
  return cube;
}

constexpr PerArm<std::string_view> kBeamNames{"x", "y", "z"};

void beam_sections(Fields fields, Fields common, MicroNanoParameters& plant) {
  const InterferometerParameters device = interferometer_section(common, plant.parts);
  common.finish();
  for (std::size_t i = 0; i < kArms; ++i) {
    Fields one = fields.table(kBeamNames[i]);
    plant.beams[i] = {.offset_u_mm = one.within("offset_u_mm", -15, 15),
                      .offset_v_mm = one.within("offset_v_mm", -15, 15),
                      .sign = kBeamNames[i] == "z" ? -1.0 : 1.0};  // from above, shown upwards
    plant.interferometers.push_back(device);
    plant.interferometers.back().dead_path_mm = one.within("dead_path_mm", 1, 2000);
    plant.interferometers.back().sign = plant.beams[i].sign;
    one.finish();
  }
  fields.finish();
}

void loop_sections(Fields fields, const Materials& materials, MicroNanoParameters& plant) {
  for (const auto& name : fields.table_names()) {
    Fields one = fields.table(name);
    const std::string beam = one.text("beam"), member = one.text("member");
    const auto found = std::find(kBeamNames.begin(), kBeamNames.end(), beam);
    if (found == kBeamNames.end()) one.fail("beam", "found '" + beam + "', expected x, y or z");
    if (member != "datum" && member != "device") {
      one.fail("member", "found '" + member + "', expected datum or device");
    }
    auto& owner = plant.beams[static_cast<std::size_t>(found - kBeamNames.begin())];
    (member == "datum" ? owner.datum : owner.device)
        .push_back({.mm = one.within("length_mm", -2000, 2000),
                    .expansion_per_k = expansion_named(one, "material", materials),
                    .parts = parts_named(one, "parts", plant.parts)});
    one.finish();
  }
}

OpticsParameters optics_section(Fields f) {
  OpticsParameters optics{.offset_mm = f.within("offset_mm", 0, 10),
                          .alignment_arcsec = f.within("alignment_arcsec", 0, 100),
                          .tilt_limit_arcsec = f.positive("tilt_limit_arcsec"),
                          .fold_height_mm = f.within("fold_height_mm", 1, 1000),
                          .fold_span_mm = f.within("fold_span_mm", 10, 1000)};
  f.finish();
  return optics;
}

CollimatorParameters collimator_section(Fields f) {
  CollimatorParameters c{.range_arcsec = f.positive("range_arcsec"),
                         .noise_arcsec = f.not_negative("noise_arcsec"),
                         .noise_s = f.positive("noise_s"),
                         .drift_arcsec = f.not_negative("drift_arcsec"),
                         .drift_s = f.positive("drift_s"),
                         .alignment_arcsec = f.not_negative("alignment_arcsec"),
                         .roll_mrad = f.within("roll_mrad", 0, 100),
                         .scale_error = f.within("scale_error", 0, 0.5)};
  f.finish();
  return c;
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
  beam_sections(root.table("beam"), root.table("interferometer"), plant);
  loop_sections(root.table("loop"), materials, plant);
  plant.optics = optics_section(root.table("optics"));
  plant.collimator = collimator_section(root.table("collimator"));
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
  hidden_sections(root, materials, plant);
  root.finish();
  return plant;
}

}  // namespace driftwise::simulated
