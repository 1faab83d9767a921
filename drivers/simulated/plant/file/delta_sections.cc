#include "drivers/simulated/plant/file/delta_sections.h"

#include <algorithm>

namespace driftwise::simulated {
namespace {
constexpr PerArm<std::string_view> kBeamNames{"x", "y", "z"};

}  // namespace

Vec3 vector_of(Fields& fields, std::string_view key) {
  const auto numbers = fields.numbers(key, 3);
  return {numbers[0], numbers[1], numbers[2]};
}

DeltaParameters flexure_delta_section(Fields& f, const Materials& materials,
                                      const std::vector<PartParameters>& parts) {
  DeltaParameters d;
  d.platform_radius_mm = f.within("platform_radius_mm", 1, 1000);
  d.arm_mm = f.within("arm_mm", 10, 1000);
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
  d.platform_part = part_index(f, "", "platform", parts);
  for (std::size_t i = 0; i < kArms; ++i) {
    const std::string number = std::to_string(i + 1);
    d.arm_part[i] = part_index(f, "", "arms_" + number, parts);
    d.scale_part[i] = part_index(f, "", "stage_" + number, parts);
  }
  return d;
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

OpticsParameters optics_section(Fields& f) {
  OpticsParameters optics{.offset_mm = f.within("offset_mm", 0, 10),
                          .alignment_arcsec = f.within("alignment_arcsec", 0, 100),
                          .tilt_limit_arcsec = f.positive("tilt_limit_arcsec")};
  return optics;
}

CollimatorParameters collimator_section(Fields f, const std::vector<PartParameters>& parts) {
  CollimatorParameters c{.range_arcsec = f.positive("range_arcsec"),
                         .noise_arcsec = f.not_negative("noise_arcsec"),
                         .noise_s = f.positive("noise_s"),
                         .drift_arcsec = f.not_negative("drift_arcsec"),
                         .drift_s = f.positive("drift_s"),
                         .alignment_arcsec = f.not_negative("alignment_arcsec"),
                         .roll_mrad = f.within("roll_mrad", 0, 100),
                         .scale_error = f.within("scale_error", 0, 0.5)};
  if (f.has("mirror_arcsec_per_k")) {
    c.mirror_arcsec_per_k = f.within("mirror_arcsec_per_k", -100, 100);
    c.mirror_part = part_named(f, "mirror_part", parts);
  }
  f.finish();
  return c;
}

void beam_sections(Fields fields, Fields common, const PerArm<double>& signs, CellParameters& plant,
                   PerArm<BeamParameters>& beams) {
  const InterferometerParameters device = interferometer_section(common, plant.parts);
  common.finish();
  for (std::size_t i = 0; i < kArms; ++i) {
    Fields one = fields.table(kBeamNames[i]);
    beams[i] = {.offset_u_mm = one.within("offset_u_mm", -15, 15),
                .offset_v_mm = one.within("offset_v_mm", -15, 15),
                .sign = signs[i]};
    plant.interferometers.push_back(device);
    plant.interferometers.back().dead_path_mm = one.within("dead_path_mm", 1, 2000);
    plant.interferometers.back().sign = beams[i].sign;
    one.finish();
  }
  fields.finish();
}

void loop_sections(Fields fields, const Materials& materials,
                   const std::vector<PartParameters>& parts, PerArm<BeamParameters>& beams) {
  for (const auto& name : fields.table_names()) {
    Fields one = fields.table(name);
    const std::string beam = one.text("beam"), member = one.text("member");
    const auto found = std::find(kBeamNames.begin(), kBeamNames.end(), beam);
    if (found == kBeamNames.end()) one.fail("beam", "found '" + beam + "', expected x, y or z");
    if (member != "datum" && member != "device") {
      one.fail("member", "found '" + member + "', expected datum or device");
    }
    auto& owner = beams[static_cast<std::size_t>(found - kBeamNames.begin())];
    (member == "datum" ? owner.datum : owner.device)
        .push_back({.mm = one.within("length_mm", -2000, 2000),
                    .expansion_per_k = expansion_named(one, "material", materials),
                    .parts = parts_named(one, "parts", parts)});
    one.finish();
  }
}

}  // namespace driftwise::simulated
