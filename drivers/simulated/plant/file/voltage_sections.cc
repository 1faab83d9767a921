#include "drivers/simulated/plant/file/plant_sections.h"

namespace driftwise::simulated {
namespace {

constexpr std::size_t kMostSources = 32;

VoltageParameters voltage_section(Fields f, const std::string& name, int axes) {
  using Sees = VoltageParameters::Sees;
  VoltageParameters p{.name = name,
                      .input = f.whole("input", 101, 420),
                      .volt_per_unit = f.number("volt_per_unit"),
                      .zero_v = f.has("zero_v") ? f.within("zero_v", -100, 100) : 0,
                      .noise_v = f.not_negative("noise_v"),
                      .limit_v = f.positive("limit_v")};
  const std::string sees = f.text("sees");
  if (sees == "height") {
    p.sees = Sees::height;
    p.x_mm = f.within("x_mm", -1e4, 1e4);
    p.y_mm = f.within("y_mm", -1e4, 1e4);
  } else if (sees == "motor") {
    p.sees = Sees::motor;
    p.axis = f.whole("axis", 1, axes) - 1;
    p.stiffness_n_mm = f.number("stiffness_n_mm");
    p.friction_n = f.not_negative("friction_n");
    p.travel_mm = f.positive("travel_mm");
    p.load_share = f.has("load_share") ? f.within("load_share", -10, 10) : 0;
    p.column = f.text_or("column", "force_N");
  } else if (sees == "column") {
    p.column = f.text("column");
    p.is_sine = f.text_or("curve", "linear") == "sine";
    if (p.is_sine && !p.column.ends_with("_arcsec"))
      f.fail("curve", "found sine of " + p.column + ", expected a column in arcsec");
  } else {
    f.fail("sees", "found '" + sees + "', expected column, height or motor");
  }
  f.finish();
  return p;
}

}  // namespace

void voltage_sections(Fields& root, CellParameters& cell) {
  if (!root.has("voltage")) return;
  Fields fields = root.table("voltage");
  for (const auto& name : fields.table_names()) {
    Fields one = fields.table(name);
    auto source = voltage_section(one, name, static_cast<int>(cell.axes.size()));
    for (const auto& other : cell.voltages)
      if (other.input == source.input)
        one.fail("input", "found " + std::to_string(source.input) + ", which " + other.name +
                              " has already; expected one input per sensor");
    cell.voltages.push_back(std::move(source));
  }
  if (cell.voltages.size() > kMostSources)
    root.fail("voltage", "found more than " + std::to_string(kMostSources) + ", expected fewer");
}

}  // namespace driftwise::simulated
