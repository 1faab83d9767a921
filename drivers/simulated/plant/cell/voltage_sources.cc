#include "drivers/simulated/plant/cell/voltage_sources.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "drivers/simulated/plant/numbers/units.h"

namespace driftwise::simulated {
namespace {

// Columns of the truth that a source of this kind looks at.
std::vector<std::string> columns_of(const VoltageParameters& p) {
  if (p.sees == VoltageParameters::Sees::height) return {"z_nm", "rx_arcsec", "ry_arcsec"};
  if (p.sees == VoltageParameters::Sees::column || p.load_share != 0) return {p.column};
  return {};
}

}  // namespace

VoltageSources::VoltageSources(std::vector<VoltageParameters> sources, std::uint64_t seed) {
  for (auto& one : sources) {
    Random noise(seed, "voltage." + one.name);
    sources_.push_back({std::move(one), noise, {}, 0, 0, false});
  }
}

const VoltageSources::Source* VoltageSources::find(int input) const {
  const auto found =
      std::ranges::find(sources_, input, [](const Source& one) { return one.parameters.input; });
  return found == sources_.end() ? nullptr : &*found;
}

bool VoltageSources::sees_motors() const {
  return std::ranges::any_of(sources_, [](const Source& one) {
    return one.parameters.sees == VoltageParameters::Sees::motor;
  });
}

void VoltageSources::check(const std::vector<std::string>& columns) const {
  for (const auto& source : sources_)
    for (const auto& column : columns_of(source.parameters))
      if (std::ranges::find(columns, column) == columns.end())
        throw std::out_of_range("voltage." + source.parameters.name + ": this plant has no " +
                                column);
}

void VoltageSources::follow(const std::function<double(int axis)>& scale_mm) {
  for (auto& source : sources_) {
    const auto& p = source.parameters;
    if (p.sees != VoltageParameters::Sees::motor) continue;
    const double here_mm = scale_mm(p.axis);
    // Dahl's model with a stiffness of friction_n over travel_mm, linear between its ends.
    if (source.begun && p.travel_mm > 0)
      source.friction_share =
          std::clamp(source.friction_share + (here_mm - source.last_mm) / p.travel_mm, -1.0, 1.0);
    source.last_mm = here_mm;
    source.begun = true;
  }
}

double VoltageSources::seen(Source& source, const std::function<double(const std::string&)>& column,
                            const std::function<double(int axis)>& scale_mm) const {
  const auto& p = source.parameters;
  switch (p.sees) {
    case VoltageParameters::Sees::column:
      return column(p.column);
    case VoltageParameters::Sees::height: {
      const double rx = column("rx_arcsec") * kRadPerArcsec;
      const double ry = column("ry_arcsec") * kRadPerArcsec;
      // The plate's normal is Ry Rx e_z; the sensor looks along z at the place (x_mm, y_mm).
      return column("z_nm") / kNmPerMm - std::tan(ry) * p.x_mm +
             std::tan(rx) / std::cos(ry) * p.y_mm;
    }
    case VoltageParameters::Sees::motor:
      return p.stiffness_n_mm * scale_mm(p.axis) +
             (p.load_share != 0 ? p.load_share * column(p.column) : 0.0) +
             p.friction_n * source.friction_share;
  }
  return 0;
}

double VoltageSources::volt(int input, const std::function<double(const std::string&)>& column,
                            const std::function<double(int axis)>& scale_mm) {
  auto* source = const_cast<Source*>(find(input));
  if (source == nullptr) return std::numeric_limits<double>::quiet_NaN();
  if (source->forced_v) return *source->forced_v;
  const auto& p = source->parameters;
  const double value = seen(*source, column, scale_mm);
  const double shape = p.is_sine ? std::sin(value * kRadPerArcsec) : value;
  const double clean_v = p.zero_v + p.volt_per_unit * shape + p.noise_v * source->noise.gaussian();
  return std::clamp(clean_v, -p.limit_v, p.limit_v);
}

void VoltageSources::force(int input, std::optional<double> volt) {
  if (auto* source = const_cast<Source*>(find(input))) source->forced_v = volt;
}

}  // namespace driftwise::simulated
