#include "server/compensation/snapshot.h"

#include <algorithm>

namespace driftwise::compensation {
namespace {

struct Name {
  std::string_view symbol, unit;
};
constexpr std::array<Name, kVariables> kNames = {{{"x", "mm"},
                                                  {"y", "mm"},
                                                  {"z", "mm"},
                                                  {"rx", "arcsec"},
                                                  {"ry", "arcsec"},
                                                  {"rz", "arcsec"},
                                                  {"force", "N"}}};

}  // namespace

std::optional<Variable> variable_from(std::string_view symbol) {
  const auto found = std::ranges::find(kNames, symbol, &Name::symbol);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<Variable>(found - kNames.begin());
}

Channel channel_of(Variable variable) {
  const Name& name = kNames[static_cast<std::size_t>(variable)];
  return {std::string(name.symbol), std::string(name.unit)};
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

}  // namespace driftwise::compensation
