#include "server/compensation/snapshot.h"

#include <algorithm>

#include "server/compensation/basis_values.h"
#include "server/compensation/target.h"

namespace driftwise::compensation {
namespace {

struct Name {
  std::string_view symbol, unit, full;
};
constexpr std::array<Name, kVariables> kNames = {{{"x", "mm", "x_mm"},
                                                  {"y", "mm", "y_mm"},
                                                  {"z", "mm", "z_mm"},
                                                  {"rx", "arcsec", "rx_arcsec"},
                                                  {"ry", "arcsec", "ry_arcsec"},
                                                  {"rz", "arcsec", "rz_arcsec"},
                                                  {"force", "N", "force_N"}}};

}  // namespace

double excess_of(double min, double max, double value) {
  const double beyond = std::max(min - value, value - max);
  if (!(beyond > 0)) return 0;
  const double half_width = 0.5 * (max - min);
  return half_width > 0 ? beyond / half_width : 1.0;
}

std::optional<Variable> variable_from(std::string_view symbol) {
  const auto found = std::ranges::find(kNames, symbol, &Name::symbol);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<Variable>(found - kNames.begin());
}

Channel channel_of(Variable variable) {
  const Name& name = kNames[static_cast<std::size_t>(variable)];
  return {std::string(name.symbol), std::string(name.unit)};
}

std::string_view name_of(Variable variable) {
  return kNames[static_cast<std::size_t>(variable)].full;
}

std::optional<Variable> variable_named(std::string_view name) {
  const auto found = std::ranges::find(kNames, name, &Name::full);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<Variable>(found - kNames.begin());
}

std::string_view to_string(UncertaintySource source) {
  switch (source) {
    case UncertaintySource::fit:
      return "fit";
    case UncertaintySource::residual:
      return "residual";
    case UncertaintySource::temperatures:
      return "temperatures";
    case UncertaintySource::laser:
      return "laser";
    case UncertaintySource::drift:
      return "drift";
    case UncertaintySource::beam_offset:
      return "beam_offset";
    case UncertaintySource::tilts:
      return "tilts";
    case UncertaintySource::beam_direction:
      return "beam_direction";
    case UncertaintySource::mirror:
      return "mirror";
    case UncertaintySource::force:
      return "force";
    case UncertaintySource::scale:
      return "scale";
    case UncertaintySource::extrapolation:
      return "extrapolation";
  }
  return "fit";
}

bool have_same_terms(const Snapshot& a, const Snapshot& b) {
  return a.products == b.products && a.column_per_unit == b.column_per_unit &&
         a.column_shift == b.column_shift;
}

NearName set_near(TargetRequest& request, std::string_view channel, double value) {
  if (channel.size() != 6 || channel[0] != 'q' || channel[1] < '1' || channel[1] > '9')
    return NearName::unknown;
  const std::string_view unit = channel.substr(2);
  if (unit != "_rad" && unit != "_deg") return NearName::unknown;
  const auto joint = static_cast<std::size_t>(channel[1] - '1');
  if ((request.near >> joint & 1) != 0) return NearName::twice;
  request.near |= 1u << joint;
  request.near_rad[joint] = unit == "_deg" ? value * kRadPerDeg : value;
  return NearName::taken;
}

double arcsec_of(const Channel& joint, double micro_units) {
  return 1e-6 * micro_units * summary_unit(joint.unit).factor;
}

}  // namespace driftwise::compensation
