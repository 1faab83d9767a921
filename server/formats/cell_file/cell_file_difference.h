#pragma once
// What differs between two cell files, by meaning: comments, order, spelling of numbers and
// defaults that are written out count for nothing. Pure.
//
// Devices are matched by their id, probes, axes and angles by their channel, beams by their length,
// branches and links by their motor. A change asks for a person unless it is one of those below,
// which are recorded only:
//
//   [cell], [web], [access], [clock], [run], [serving], [backup], [[notify]], [watchdog] and
//   [[channel_alarm]]: a run keeps the rules that it began with, and the others say how the daemon
//   is reached, how often it looks and whom it tells; of a device: the port of its address,
//   timeout_s, period_s; of [kinematics]: hold.
//
// Secrets are compared and not shown (without_secrets.h): a changed password reads "[removed]" on
// both sides.
//
// A key that this list does not know asks: what a later version adds is not passed over. Two
// devices that have exchanged their addresses are two instruments exchanged, and ask.

#include <string>
#include <string_view>
#include <vector>

#include "server/core/description/cell_description.h"

namespace driftwise::formats {

struct ConfigurationChange {
  std::string place;          // "probe t07_degC", "device laser-x", "beam x_mm", "checks"
  std::string key;            // "input"; empty: the whole of it came or went
  std::string before, after;  // as a person reads them; empty: it was not there
  bool asks = false;
  std::vector<std::string> affects;  // symbols whose meaning it may change: "t07"; ascending
  bool operator==(const ConfigurationChange&) const = default;
};

// before_text is read with the kinds of `after`. Those that ask first, then in order of the places.
// Text that is no cell file (any more) differs as a whole: one change that asks and affects every
// channel of `after`.
std::vector<ConfigurationChange> cell_file_difference(std::string_view before_text,
                                                      const CellDescription& after);

bool any_asks(const std::vector<ConfigurationChange>& changes);
// "probe t07_degC: input 107 -> 108"
std::string sentence(const ConfigurationChange& change);

// As the store keeps them; reading answers with none for a text that is no such list, and removes
// the secrets of one that an earlier program stored.
std::string write_changes_json(const std::vector<ConfigurationChange>& changes);
std::vector<ConfigurationChange> read_changes_json(const std::string& json);

}  // namespace driftwise::formats
