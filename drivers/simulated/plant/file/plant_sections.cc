#include "drivers/simulated/plant/file/plant_sections.h"

#include <algorithm>
#include <cmath>

namespace driftwise::simulated {
namespace {

constexpr std::size_t kMaxParts = 36, kMaxThermometers = 16;
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

double per_kelvin(double ppm_k) { return ppm_k * 1e-6; }

std::vector<PartParameters> parts_section(Fields fields, const Materials& materials) {
  std::vector<PartParameters> parts;
  for (const auto& name : fields.table_names()) parts.push_back({.name = name});
  for (auto& part : parts) {
    Fields one = fields.table(part.name);
    if (one.has("heat_capacity_j_k")) {
      part.capacity_j_k = one.positive("heat_capacity_j_k");
    } else {
      const Material& material = material_named(one, "material", materials);
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
      link.conductance_w_k = material_named(one, "material", materials).conductivity_w_mk *
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

std::vector<ThermometerParameters> thermometers_section(Fields fields,
                                                        const std::vector<PartParameters>& parts) {
  std::vector<ThermometerParameters> thermometers;
  for (const auto& name : fields.table_names()) {
    Fields one = fields.table(name);
    ThermometerParameters t{.name = name,
                            .input = one.whole("input", 101, 420),
                            .parts = parts_named(one, "parts", parts),
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

}  // namespace

const Material& material_named(Fields& fields, std::string_view key, const Materials& materials) {
  const std::string name = fields.text(key);
  const auto found = materials.find(name);
  if (found != materials.end()) return found->second;
  std::string known;
  for (const auto& [other, unused] : materials) known += (known.empty() ? "" : ", ") + other;
  fields.fail(key, "found '" + name + "', expected one of the materials: " + known);
}

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

std::vector<int> parts_named(Fields& fields, std::string_view key,
                             const std::vector<PartParameters>& parts) {
  std::vector<int> nodes;
  for (const auto& name : fields.texts(key)) {
    nodes.push_back(part_index(fields, key, name, parts));
  }
  return nodes;
}

double expansion_named(Fields& fields, std::string_view key, const Materials& materials) {
  return per_kelvin(material_named(fields, key, materials).expansion_ppm_k);
}

Materials cell_sections(Fields& root, Fields& head, CellParameters& cell) {
  Materials materials = materials_section(root.table("material"));
  cell.reference_degc = head.within("reference_degc", -50, 100);
  cell.start_hours_before = head.within("start_hours_before", 0, 1000);
  if (head.has("step_s")) cell.step_s = head.within("step_s", 0.01, 5);
  cell.parts = parts_section(root.table("part"), materials);
  if (cell.parts.size() > kMaxParts) {
    root.fail("part", "found more than " + std::to_string(kMaxParts) + " parts, expected fewer");
  }
  cell.links = links_section(root.table("link"), materials, cell.parts);
  cell.room = room_section(root.table("room"));
  Fields scanner = root.table("scanner");
  cell.scanner_noise_ohm = scanner.not_negative("noise_ohm");
  cell.scanner_resolution_ohm = scanner.positive("resolution_ohm");
  scanner.finish();
  cell.thermometers = thermometers_section(root.table("thermometer"), cell.parts);
  if (cell.thermometers.size() > kMaxThermometers) {
    root.fail("thermometer",
              "found more than " + std::to_string(kMaxThermometers) + ", expected fewer");
  }
  return materials;
}

}  // namespace driftwise::simulated
