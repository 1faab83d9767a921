#include "drivers/simulated/plant/plant_sections.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace driftwise::simulated {
namespace {

using Materials = std::map<std::string, Material, std::less<>>;

constexpr double kAirHeat_j_m3k = 1.2 * 1005;  // density x heat capacity at 20 degC

Materials materials_section(Fields fields) {
  Materials materials;
  for (const auto& name : fields.table_names()) {
    Fields one = fields.table(name);
    materials[name] = {.density_kg_m3 = one.positive("density_kg_m3"),
                       .heat_capacity_j_kgk = one.positive("heat_capacity_j_kgk"),
                       .conductivity_w_mk = one.positive("conductivity_w_mk"),
                       .expansion_ppm_k = one.within("expansion_ppm_k", -10, 200)};
    one.finish();
  }
  return materials;
}

const Material& material_named(Fields& fields, const Materials& materials) {
  const std::string name = fields.text("material");
  const auto found = materials.find(name);
  if (found != materials.end()) return found->second;
  std::string known;
  for (const auto& [other, unused] : materials) known += (known.empty() ? "" : ", ") + other;
  fields.fail("material", "found '" + name + "', expected one of the materials: " + known);
}

double per_kelvin(double ppm_k) { return ppm_k * 1e-6; }

std::vector<PartParameters> parts_section(Fields fields, const Materials& materials) {
  std::vector<PartParameters> parts;
  for (const auto& name : fields.table_names()) parts.push_back({.name = name});
  for (auto& part : parts) {
    Fields one = fields.table(part.name);
    if (one.has("heat_capacity_j_k")) {
      part.capacity_j_k = one.positive("heat_capacity_j_k");
    } else {
      const Material& material = material_named(one, materials);
      part.capacity_j_k = one.positive("mass_kg") * material.heat_capacity_j_kgk;
      part.expansion_per_k = per_kelvin(material.expansion_ppm_k);
    }
    if (one.has("film_w_m2k")) {
      part.film_w_k = one.not_negative("film_w_m2k") * one.not_negative("area_cm2") * 1e-4;
      const std::string air = one.text_or("air", "cover_air");
      part.air = air == "room" ? kRoom : part_index(one, "air", air, parts);
    }
    one.finish();
  }
  return parts;
}

int end_of_link(const Fields& fields, const std::string& name,
                const std::vector<PartParameters>& parts) {
  return name == "room" ? kRoom : part_index(fields, "between", name, parts);
}

std::vector<LinkParameters> links_section(Fields fields, const Materials& materials,
                                          const std::vector<PartParameters>& parts) {
  std::vector<LinkParameters> links;
  for (const auto& name : fields.table_names()) {
    Fields one = fields.table(name);
    LinkParameters link{.name = name};
    const auto ends = one.texts("between");
    if (ends.size() != 2 || ends[0] == ends[1]) {
      one.fail("between",
               "found " + std::to_string(ends.size()) + " names, expected two different ones");
    }
    link.from = end_of_link(one, ends[0], parts);
    link.to = end_of_link(one, ends[1], parts);
    const std::string kind = one.text("kind");
    if (kind == "conduction") {
      link.conductance_w_k = material_named(one, materials).conductivity_w_mk *
                             one.positive("section_mm2") * 1e-6 /
                             (one.positive("length_mm") * 1e-3);
    } else if (kind == "contact") {
      link.conductance_w_k = one.positive("conductance_w_m2k") * one.positive("area_mm2") * 1e-6;
    } else if (kind == "flow") {
      link.conductance_w_k = one.not_negative("flow_m3_h") / 3600 * kAirHeat_j_m3k;
    } else {
      one.fail("kind", "found '" + kind + "', expected conduction, contact or flow");
    }
    one.finish();
    links.push_back(std::move(link));
  }
  return links;
}

std::vector<int> parts_named(Fields& fields, const std::vector<PartParameters>& parts) {
  std::vector<int> nodes;
  for (const auto& name : fields.texts("parts")) {
    nodes.push_back(part_index(fields, "parts", name, parts));
  }
  return nodes;
}

std::vector<LoopParameters> loop_section(Fields fields, const std::vector<PartParameters>& parts) {
  std::vector<LoopParameters> loop;
  for (const auto& name : fields.table_names()) {
    Fields one = fields.table(name);
    LoopParameters piece{.name = name};
    piece.parts = parts_named(one, parts);
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
  BendingParameters bending{
      .top = part_named(fields, "top", parts),
      .bottom = part_named(fields, "bottom", parts),
      .expansion_per_k = per_kelvin(material_named(fields, materials).expansion_ppm_k),
      .node_distance_mm = fields.positive("node_distance_mm"),
      .span_mm = fields.number("span_mm"),
      .height_mm = fields.number("height_mm")};
  fields.finish();
  return bending;
}

ParallelogramParameters parallelogram_section(Fields fields, const Materials& materials,
                                              const std::vector<PartParameters>& parts) {
  ParallelogramParameters p{
      .left_part = part_named(fields, "left_part", parts),
      .right_part = part_named(fields, "right_part", parts),
      .expansion_per_k = per_kelvin(material_named(fields, materials).expansion_ppm_k),
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

std::vector<ThermometerParameters> thermometers_section(Fields fields,
                                                        const std::vector<PartParameters>& parts) {
  std::vector<ThermometerParameters> thermometers;
  for (const auto& name : fields.table_names()) {
    Fields one = fields.table(name);
    ThermometerParameters t{.name = name,
                            .input = one.whole("input", 101, 420),
                            .parts = parts_named(one, parts),
                            .lag_s = one.positive("lag_s"),
                            .stem = one.within("stem", 0, 1),
                            .r0_ohm = one.positive("r0_ohm"),
                            .a_per_k = one.positive("a_per_k"),
                            .b_per_k2 = one.within("b_per_k2", -1e-5, 0),
                            .certificate_r0_ohm = one.positive("certificate_r0_ohm")};
    for (const auto& other : thermometers) {
      if (other.input == t.input) {
        one.fail("input", "found " + std::to_string(t.input) + ", which " + other.name +
                              " has already; expected one input per probe");
      }
    }
    one.finish();
    thermometers.push_back(std::move(t));
  }
  return thermometers;
}

// The pieces lead from the head to the mirror through metal; air is the straight way.
void check_closure(const Fields& root, const PlantParameters& plant) {
  double sum_mm = 0;
  for (const auto& piece : plant.loop) sum_mm += piece.length_mm;
  if (std::abs(sum_mm - plant.interferometer.dead_path_mm) > 1e-6) {
    root.fail("loop", "the lengths sum to " + std::to_string(sum_mm) +
                          " mm, expected interferometer.dead_path_mm = " +
                          std::to_string(plant.interferometer.dead_path_mm) + ": a loop closes");
  }
}

}  // namespace

int part_index(const Fields& fields, std::string_view key, std::string_view name,
               const std::vector<PartParameters>& parts) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].name == name) return static_cast<int>(i);
  }
  std::string known;
  for (const auto& part : parts) known += (known.empty() ? "" : ", ") + part.name;
  fields.fail(key, "found '" + std::string(name) + "', expected one of the parts: " + known);
}

int part_named(Fields& fields, std::string_view key, const std::vector<PartParameters>& parts) {
  return part_index(fields, key, fields.text(key), parts);
}

PlantParameters plant_sections(Fields root) {
  PlantParameters plant;
  Fields head = root.table("plant");
  if (const std::string kind = head.text("kind"); kind != "linear-axis") {
    head.fail("kind", "found '" + kind + "', expected linear-axis");
  }
  plant.reference_degc = head.within("reference_degc", -50, 100);
  plant.start_hours_before = head.within("start_hours_before", 0, 1000);
  head.finish();

  const Materials materials = materials_section(root.table("material"));
  plant.parts = parts_section(root.table("part"), materials);
  if (plant.parts.size() > 32) root.fail("part", "found more than 32 parts, expected fewer");
  plant.links = links_section(root.table("link"), materials, plant.parts);
  plant.loop = loop_section(root.table("loop"), plant.parts);
  plant.bending = bending_section(root.table("bending"), materials, plant.parts);
  plant.parallelogram = parallelogram_section(root.table("parallelogram"), materials, plant.parts);
  plant.axis = axis_section(root.table("axis"), plant.parts);
  plant.room = room_section(root.table("room"));
  plant.interferometer = interferometer_section(root.table("interferometer"), plant.parts);
  plant.stabiliser = stabiliser_section(root.table("stabiliser"), plant.parts);
  Fields scanner = root.table("scanner");
  plant.scanner_noise_ohm = scanner.not_negative("noise_ohm");
  plant.scanner_resolution_ohm = scanner.positive("resolution_ohm");
  scanner.finish();
  plant.thermometers = thermometers_section(root.table("thermometer"), plant.parts);
  root.finish();
  check_closure(root, plant);
  return plant;
}

}  // namespace driftwise::simulated
