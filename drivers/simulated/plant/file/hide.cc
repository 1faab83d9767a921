#include "drivers/simulated/plant/file/hide.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <set>

#include "drivers/simulated/plant/file/make_plant.h"

namespace driftwise::simulated {
namespace {

enum class Place { axis, beam, thermometer };

// Mechanism of a cause. Ranges: the sources of docs/plants/hidden.md; where a mechanism has several
// figures, one of them is the size and the others stand at the middle of theirs.
struct Recipe {
  std::string_view cause, unit;
  Place place;
  double least, most;  // of the size
  bool drawn;          // by "random": a plan of some hours over the stroke can show it
};

constexpr std::array kRecipes = {
    // Two times friction over stiffness: 0.1 .. 1 N at 5 .. 50 N/um.
    Recipe{"backlash", "nm", Place::axis, 20, 400, true},
    // Glue: a share of each move comes late.
    Recipe{"creep", "ppm", Place::axis, 10, 100, true},
    // Walking piezo drives.
    Recipe{"self_heating", "J/mm", Place::axis, 0.2, 2, true},
    // The signal's own error; its period of 2 um is too fine for a coarse lattice of positions.
    Recipe{"cyclic_error", "nm", Place::axis, 3, 20, false},
    Recipe{"step_change", "nm", Place::axis, 40, 400, true},
    // Steel behind a film: density x heat capacity x thickness / film.
    Recipe{"thermal_lag", "s", Place::thermometer, 600, 3600, true},
    // Gain width of a helium-neon laser.
    Recipe{"instrument_drift", "ppm", Place::beam, 1, 3, true},
    Recipe{"periodic_disturbance", "nm", Place::beam, 20, 100, true},
    Recipe{"outliers", "nm", Place::beam, 158, 633, false},
    // Degrees of the eddies in the beam.
    Recipe{"noise_change", "K", Place::beam, 0.3, 1, false},
    // Ohms of a joint that went bad.
    Recipe{"sensor_fault", "ohm", Place::thermometer, 0.1, 0.5, true},
};

const CellParameters& cell_of(const PlantParameters& plant) {
  return std::visit(
      [](const auto& robot) -> const CellParameters& {
        if constexpr (std::is_base_of_v<CellParameters, std::decay_t<decltype(robot)>>)
          return robot;
        else
          return robot.upper;
      },
      plant);
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

const ThermometerParameters* thermometer_named(const CellParameters& cell,
                                               const std::string& name) {
  const auto found = std::ranges::find(cell.thermometers, name, &ThermometerParameters::name);
  return found == cell.thermometers.end() ? nullptr : &*found;
}

std::vector<std::string> symbols_of(const CellParameters& cell, Place place) {
  std::vector<std::string> symbols;
  switch (place) {
    case Place::axis:
      for (std::size_t i = 0; i < cell.axes.size(); ++i)
        symbols.push_back("q" + std::to_string(i + 1));
      break;
    case Place::beam:
      for (std::size_t i = 0; i < std::min<std::size_t>(cell.interferometers.size(), 3); ++i)
        symbols.emplace_back(1, "xyz"[i]);
      break;
    case Place::thermometer:
      for (const auto& thermometer : cell.thermometers)
        if (!thermometer.parts.empty() && thermometer.parts[0] >= 0)
          symbols.push_back(thermometer.name);
      break;
  }
  return symbols;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

// A bare name tells nobody what it is: h1, h2.
std::string mechanism(const Recipe& recipe, const std::string& symbol, double size,
                      const CellParameters& cell) {
  const std::string place = std::to_string(symbol[0] == 'q' ? std::atoi(symbol.c_str() + 1)
                                           : symbol == "y"  ? 2
                                           : symbol == "z"  ? 3
                                                            : 1);
  const std::string axis = "axis=" + place + ",", beam = "beam=" + place + ",";
  const auto* thermometer = thermometer_named(cell, symbol);
  if (recipe.cause == "backlash")
    return "kind=\"friction\"," + axis + "friction_n=" + number(size * 1e-3 / 2 * 10) +
           ",stiffness_n_um=10,presliding_um=1";
  if (recipe.cause == "creep")
    return "kind=\"viscoelastic\"," + axis + "share_ppm=" + number(size) + ",times_s=[3,20,120]";
  if (recipe.cause == "self_heating")
    return "kind=\"motor_heat\"," + axis + "part=\"" +
           cell.parts[static_cast<std::size_t>(
                          cell.axes[static_cast<std::size_t>(std::stoi(place)) - 1].motor_part)]
               .name +
           "\",material=\"aluminium\",heat_j_per_mm=" + number(size) +
           ",drive_j_k=20,carrier_j_k=20,link_w_k=0.2,sink_w_k=0.04,length_mm=30";
  if (recipe.cause == "cyclic_error")  // an offset of one percent moves the reading by 3.2 nm
    return "kind=\"scale_signals\"," + axis +
           "period_nm=2000,offset_pct=" + number(size / (2000 / (2 * M_PI)) * 100) +
           ",amplitude_pct=0,phase_deg=0";
  if (recipe.cause == "step_change") return "kind=\"slip\"," + axis + "at_h=2,nm=" + number(size);
  if (recipe.cause == "thermal_lag")
    return "kind=\"slab\",axis=1,part=\"" +
           cell.parts[static_cast<std::size_t>(thermometer->parts[0])].name +
           "\",material=\"steel\",thickness_mm=10,film_w_m2k=" + number(7850 * 480 * 0.010 / size) +
           ",length_mm=60";
  if (recipe.cause == "instrument_drift")
    return "kind=\"laser_drift\"," + beam + "ppm=" + number(size) + ",warm_up_h=4";
  if (recipe.cause == "periodic_disturbance")
    return "kind=\"level_control\"," + beam + "leak_s=500,fill_s=300,nm=" + number(size) +
           ",lag_s=40";
  if (recipe.cause == "outliers")
    return "kind=\"glitches\"," + beam + "per_hour=8,nm=" + number(size) + ",seconds=4";
  if (recipe.cause == "noise_change")
    return "kind=\"fan\"," + beam + "at_h=2.4,eddy_k=" + number(size) + ",eddy_s=3";
  return "kind=\"thermometer\",fault=\"jump\",input=" + std::to_string(thermometer->input) +
         ",at_h=2,ohm=" + number(size);
}

HiddenCause hidden_cause(const Recipe& recipe, const std::string& symbol, double size,
                         std::size_t place_in_list, const CellParameters& cell) {
  return {std::string(recipe.cause), symbol, size, std::string(recipe.unit),
          "hidden.h" + std::to_string(place_in_list + 1) + "={" +
              mechanism(recipe, symbol, size, cell) + "}"};
}

// Between the two bounds, every ratio as likely: sizes of mechanisms go over decades.
double drawn_size(const Recipe& recipe, std::mt19937_64& random) {
  const double share = std::uniform_real_distribution<double>(0, 1)(random);
  return recipe.least * std::pow(recipe.most / recipe.least, share);
}

std::vector<HiddenCause> drawn(const CellParameters& cell, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<const Recipe*> recipes;
  for (const auto& recipe : kRecipes)
    if (recipe.drawn && !symbols_of(cell, recipe.place).empty()) recipes.push_back(&recipe);
  const std::size_t count = random() % 3 == 0 ? 2 : 1;
  std::vector<HiddenCause> causes;
  std::set<std::string> taken;
  while (causes.size() < count) {
    const Recipe& recipe = *recipes[random() % recipes.size()];
    const auto symbols = symbols_of(cell, recipe.place);
    const std::string& symbol = symbols[random() % symbols.size()];
    // Thermometers of the same kind and causes of the same name cannot be told apart by anybody.
    if (!taken.insert(symbol).second || !taken.insert(std::string(recipe.cause)).second) continue;
    causes.push_back(hidden_cause(recipe, symbol, drawn_size(recipe, random), causes.size(), cell));
  }
  return causes;
}

HiddenCause asked(const std::string& item, const CellParameters& cell, std::size_t place_in_list) {
  const auto colon = item.find(':'), equals = item.find('=');
  const std::string name = item.substr(0, std::min(colon, equals));
  const auto recipe = std::ranges::find(kRecipes, name, &Recipe::cause);
  if (recipe == kRecipes.end()) {
    std::vector<std::string> names;
    for (const auto& one : kRecipes) names.emplace_back(one.cause);
    throw PlantFileError("--hide: found '" + item +
                         "', expected random or a cause: " + joined(names));
  }
  const auto symbols = symbols_of(cell, recipe->place);
  std::string symbol = symbols.empty() ? "" : symbols.front();
  if (colon != std::string::npos)
    symbol = item.substr(colon + 1, equals == std::string::npos ? equals : equals - colon - 1);
  if (std::ranges::find(symbols, symbol) == symbols.end())
    throw PlantFileError("--hide: '" + item + "': found '" + symbol + "', expected one of " +
                         joined(symbols) + ", as in " + name + ":" +
                         (symbols.empty() ? "q1" : symbols.front()));
  double size = std::sqrt(recipe->least * recipe->most);
  if (equals != std::string::npos) {
    char* end = nullptr;
    const char* from = item.c_str() + equals + 1;
    size = std::strtod(from, &end);
    if (end == from || recipe->unit != end || !(size >= recipe->least / 10) ||
        !(size <= recipe->most * 10))
      throw PlantFileError("--hide: '" + item + "': expected a size in " +
                           std::string(recipe->unit) + " from " + number(recipe->least / 10) +
                           " to " + number(recipe->most * 10) + ", as in " + name + ":" + symbol +
                           "=" + number(std::sqrt(recipe->least * recipe->most)) +
                           std::string(recipe->unit));
  }
  return hidden_cause(*recipe, symbol, size, place_in_list, cell);
}

}  // namespace

std::vector<HiddenCause> hide(const std::string& wanted, const PlantParameters& plant,
                              std::uint64_t seed) {
  const CellParameters& cell = cell_of(plant);
  if (wanted == "random") return drawn(cell, seed);
  std::vector<HiddenCause> causes;
  for (std::size_t from = 0; from <= wanted.size();) {
    const auto comma = std::min(wanted.find(',', from), wanted.size());
    causes.push_back(asked(wanted.substr(from, comma - from), cell, causes.size()));
    from = comma + 1;
  }
  return causes;
}

std::string hidden_answer_json(const std::vector<HiddenCause>& causes, std::uint64_t seed) {
  std::string text =
      "{\"schema\":\"driftwise.hidden.v1\",\"seed\":" + std::to_string(seed) + ",\"hidden\":[";
  for (const auto& cause : causes) {
    if (&cause != &causes.front()) text += ",";
    text += "{\"cause\":\"" + cause.cause + "\",\"symbol\":\"" + cause.symbol +
            "\",\"size\":" + number(cause.size) + ",\"unit\":\"" + cause.unit + "\"}";
  }
  return text + "]}\n";
}

}  // namespace driftwise::simulated
