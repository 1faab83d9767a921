#include "drivers/simulated/plant/file/hidden_sections.h"

#include <map>

#include "drivers/simulated/plant/hidden/hidden_mechanism.h"

namespace driftwise::simulated {
namespace {

constexpr double kLongest_h = 1000;

// One table, with what it may name.
struct HiddenReader {
  Fields& f;
  const Materials& materials;
  const CellParameters& cell;

  int axis() { return f.whole("axis", 1, static_cast<int>(cell.axes.size())) - 1; }
  int beam() { return f.whole("beam", 1, static_cast<int>(cell.interferometers.size())) - 1; }
  int part() { return part_named(f, "part", cell.parts); }
  double hours(std::string_view key) { return f.within(key, 0, kLongest_h); }
  int input(std::string_view key) {
    const int input = f.whole(key, 101, 420);
    for (const auto& thermometer : cell.thermometers)
      if (thermometer.input == input) return input;
    f.fail(key, "found " + std::to_string(input) + ", expected a thermometer's scanner input");
  }

  HiddenEffect slab() {
    const Material& material = material_named(f, "material", materials);
    HiddenSlab slab{.axis = axis(),
                    .part = part(),
                    .thickness_mm = f.within("thickness_mm", 0.1, 200),
                    .film_w_m2k = f.positive("film_w_m2k"),
                    .density_kg_m3 = material.density_kg_m3,
                    .heat_capacity_j_kgk = material.heat_capacity_j_kgk,
                    .conductivity_w_mk = material.conductivity_w_mk,
                    .expansion_per_k = material.expansion_ppm_k * 1e-6,
                    .bends = f.has("span_mm")};
    slab.length_mm = f.within(slab.bends ? "span_mm" : "length_mm", -1000, 1000);
    return slab;
  }
  HiddenEffect motor_heat() {
    return HiddenMotorHeat{.axis = axis(),
                           .part = part(),
                           .heat_j_per_mm = f.positive("heat_j_per_mm"),
                           .drive_j_k = f.positive("drive_j_k"),
                           .carrier_j_k = f.positive("carrier_j_k"),
                           .link_w_k = f.positive("link_w_k"),
                           .sink_w_k = f.positive("sink_w_k"),
                           .length_mm = f.within("length_mm", -1000, 1000),
                           .expansion_per_k = expansion_named(f, "material", materials)};
  }
  HiddenEffect friction() {
    return HiddenFriction{.axis = axis(),
                          .friction_n = f.positive("friction_n"),
                          .stiffness_n_um = f.positive("stiffness_n_um"),
                          .presliding_um = f.positive("presliding_um")};
  }
  HiddenEffect viscoelastic() {
    HiddenViscoelastic glue{.axis = axis(), .share_ppm = f.within("share_ppm", -1e4, 1e4)};
    const auto times = f.numbers("times_s", glue.times_s.size());
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (times[i] <= 0) f.fail("times_s", "found a time that is not above 0");
      glue.times_s[i] = times[i];
    }
    return glue;
  }
  HiddenEffect scale_signals() {
    return HiddenScaleSignals{.axis = axis(),
                              .period_nm = f.positive("period_nm"),
                              .offset_pct = f.within("offset_pct", -50, 50),
                              .amplitude_pct = f.within("amplitude_pct", -50, 50),
                              .phase_deg = f.within("phase_deg", -45, 45)};
  }
  HiddenEffect fringe_mixing() {
    return HiddenFringeMixing{.beam = beam(),
                              .ghost = f.within("ghost", -0.5, 0.5),
                              .mixing = f.within("mixing", -0.5, 0.5)};
  }
  HiddenEffect laser_drift() {
    return HiddenLaserDrift{
        .beam = beam(), .ppm = f.within("ppm", -10, 10), .warm_up_h = f.positive("warm_up_h")};
  }
  HiddenEffect lost_fringe() {
    return HiddenLostFringe{
        .beam = beam(), .at_h = hours("at_h"), .half_waves = f.within("half_waves", -1000, 1000)};
  }
  HiddenEffect slip() {
    return HiddenSlip{.axis = axis(), .at_h = hours("at_h"), .nm = f.within("nm", -1e6, 1e6)};
  }
  HiddenEffect level_control() {
    return HiddenLevelControl{.beam = beam(),
                              .leak_s = f.positive("leak_s"),
                              .fill_s = f.positive("fill_s"),
                              .nm = f.within("nm", 0, 1e5),
                              .lag_s = f.positive("lag_s")};
  }
  HiddenEffect particle() {
    return HiddenParticle{.axis = axis(),
                          .at_mm = f.number("at_mm"),
                          .half_width_mm = f.positive("half_width_mm"),
                          .nm = f.within("nm", -1e5, 1e5)};
  }
  HiddenEffect ball_contact() {
    return HiddenBallContact{.axis = axis(),
                             .radius_mm = f.positive("radius_mm"),
                             .youngs_gpa = f.positive("youngs_gpa")};
  }
  HiddenEffect glitches() {
    return HiddenGlitches{.beam = beam(),
                          .per_hour = f.positive("per_hour"),
                          .nm = f.within("nm", 0, 1e6),
                          .seconds = f.positive("seconds")};
  }
  HiddenEffect fan() {
    return HiddenFan{.beam = beam(),
                     .at_h = hours("at_h"),
                     .eddy_k = f.within("eddy_k", 0, 10),
                     .eddy_s = f.positive("eddy_s")};
  }
  HiddenEffect dead_path() {
    return HiddenDeadPath{.beam = beam(), .mm = f.within("mm", -1000, 1000)};
  }
  HiddenEffect weather_front() {
    return HiddenWeatherFront{
        .at_h = hours("at_h"), .over_h = f.positive("over_h"), .hpa = f.within("hpa", -50, 50)};
  }
  HiddenEffect beam_place() {
    if (cell.interferometers.size() < 2)
      f.fail("kind", "found beam_place, which needs the micro-nano's cube");
    return HiddenBeamPlace{.beam = beam(),
                           .u_mm = f.within("u_mm", -20, 20),
                           .v_mm = f.within("v_mm", -20, 20),
                           .angle_arcsec = f.within("angle_arcsec", -200, 200)};
  }
  HiddenEffect thermometer() {
    using Fault = HiddenThermometer::Fault;
    const std::string name = f.text("fault");
    HiddenThermometer fault{.input = input("input"), .at_h = hours("at_h")};
    if (name == "stuck") {
      fault.fault = Fault::stuck;
    } else if (name == "jump") {
      fault.fault = Fault::jump;
      fault.size = f.within("ohm", -100, 100);
    } else if (name == "gain") {
      fault.fault = Fault::gain;
      fault.size = f.within("factor", -10, 10);
    } else if (name == "swapped") {
      fault.fault = Fault::swapped;
      fault.other = input("other");
    } else {
      f.fail("fault", "found '" + name + "', expected stuck, jump, gain or swapped");
    }
    return fault;
  }
};

using ReadHidden = HiddenEffect (HiddenReader::*)();
const std::map<std::string, ReadHidden>& hidden_readers() {
  static const std::map<std::string, ReadHidden> readers{
      {"ball_contact", &HiddenReader::ball_contact},
      {"beam_place", &HiddenReader::beam_place},
      {"dead_path", &HiddenReader::dead_path},
      {"fan", &HiddenReader::fan},
      {"fringe_mixing", &HiddenReader::fringe_mixing},
      {"friction", &HiddenReader::friction},
      {"glitches", &HiddenReader::glitches},
      {"laser_drift", &HiddenReader::laser_drift},
      {"level_control", &HiddenReader::level_control},
      {"lost_fringe", &HiddenReader::lost_fringe},
      {"motor_heat", &HiddenReader::motor_heat},
      {"particle", &HiddenReader::particle},
      {"scale_signals", &HiddenReader::scale_signals},
      {"slab", &HiddenReader::slab},
      {"slip", &HiddenReader::slip},
      {"thermometer", &HiddenReader::thermometer},
      {"viscoelastic", &HiddenReader::viscoelastic},
      {"weather_front", &HiddenReader::weather_front}};
  return readers;
}

}  // namespace

void hidden_sections(Fields& root, const Materials& materials, CellParameters& cell) {
  if (!root.has("hidden")) return;
  Fields all = root.table("hidden");
  for (const auto& name : all.table_names()) {
    Fields one = all.table(name);
    const std::string kind = one.text("kind");
    const auto found = hidden_readers().find(kind);
    if (found == hidden_readers().end()) {
      std::string known;
      for (const auto& [other, unused] : hidden_readers()) {
        known += (known.empty() ? "" : ", ") + other;
      }
      one.fail("kind", "found '" + kind + "', expected one of: " + known);
    }
    HiddenReader reader{one, materials, cell};
    cell.hidden.push_back({name, (reader.*found->second)()});
    one.finish();
    if (const auto* air = std::get_if<HiddenDeadPath>(&cell.hidden.back().effect)) {
      cell.interferometers[static_cast<std::size_t>(air->beam)].hidden_path_mm += air->mm;
    }
    if (cell.hidden.size() > kMaxHidden) {
      root.fail("hidden", "found more than " + std::to_string(kMaxHidden) + ", expected fewer");
    }
  }
}

}  // namespace driftwise::simulated
