#include "server/application/motion/sampling_gates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/application/motion/datum_opening.h"

namespace driftwise::application {
namespace {

// Declared standard uncertainties that the readings of a rotation may spread by.
constexpr double kOwnSpread = 3;

// A coordinate whose second instrument says something else, or nothing; empty: all are confirmed.
std::string unconfirmed(const SetupDescription& setup, const Sampling& sampling) {
  for (const auto& one : setup.confirmations) {
    const double* measured = find_value(sampling.means, one.channel.name());
    if (!measured) continue;  // out of its range: there is nothing to confirm
    const auto by = std::ranges::find(setup.coordinates, one.channel, &SetupCoordinate::channel);
    const auto* confirmed = find_value(sampling.means, one.confirmed().name());
    if (!confirmed)
      return fmt::format("{} is {:.3f} by '{}' and not confirmed: '{}' gives no value",
                         one.channel.name(), *measured, by->device, one.device);
    const double difference = *confirmed - *measured;
    if (std::abs(difference) > one.limit)
      return fmt::format(
          "{} is {:.3f} by '{}' and {:.3f} by '{}': difference {:+.3f} {}, limit {:g}",
          one.channel.name(), *measured, by->device, *confirmed, one.device, difference,
          one.channel.unit, one.limit);
  }
  return {};
}

}  // namespace

Finding judge_sampling(const Sampling& sampling, const RunRules& rules,
                       const SetupDescription* confirming) {
  if (sampling.spread_nm > rules.max_spread_nm)
    return {Trouble::spread,
            spread_sentence(sampling.spread_nm, rules.readings_per_point, rules.max_spread_nm)};
  for (const auto& rotation : sampling.rotations) {
    // An instrument of coarse steps spreads by what it declares.
    const double limit_arcsec = std::max(rules.max_spread_arcsec, kOwnSpread * rotation.u_arcsec);
    if (!(rotation.arcsec > limit_arcsec)) continue;
    return {Trouble::spread, spread_sentence_arcsec(rotation.channel, rotation.arcsec,
                                                    rules.readings_per_point, limit_arcsec)};
  }
  if (confirming != nullptr)
    if (auto doubt = unconfirmed(*confirming, sampling); !doubt.empty())
      return {Trouble::spread, std::move(doubt)};
  // A scale that jumps or wanders while the instruments are read gives no position.
  if (sampling.off_nm > rules.in_position_nm || sampling.peak_to_peak_nm > rules.in_position_nm)
    return {Trouble::not_settled,
            fmt::format("the readback was up to {:.0f} nm from the commanded position and moved by "
                        "{:.0f} nm peak to peak while the instruments were read, limit {:g} nm",
                        sampling.off_nm, sampling.peak_to_peak_nm, rules.in_position_nm)};
  return {};
}

}  // namespace driftwise::application
