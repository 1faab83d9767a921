#pragma once
// Limits of every channel that the devices of a cell give: declared ones, and defaults with their
// source. Pure.

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include "server/core/description/cell_description.h"

namespace driftwise::plausibility {

enum class Missing : std::uint8_t {
  rejected,  // no value at all: a broken probe, a reading without its length
  allowed,   // the force while weights move
};

// In the unit of the channel. The defaults: finite only.
struct ChannelLimit {
  double min = -std::numeric_limits<double>::max(), max = std::numeric_limits<double>::max();
  // The most that two successive answers may differ: max_step + max_per_s * (time between them).
  double max_step = std::numeric_limits<double>::max(), max_per_s = 0;
  // A value that stepped stays in doubt until it steps back. false: only the answer of the step.
  bool latches = false;
  Missing missing = Missing::rejected;
  // Equal answers in a row that make a channel frozen: 0 never, -1 by the channel's own noise.
  int frozen_answers = 0;
  // A controller holds it: it stands still while the room moves, and moves with its set point.
  bool is_held = false;
  // Where the range comes from: "[[limit]] of the cell file", "travel of axis X".
  std::string source;
};

// device: that of the channel; channel: one that it gives, described in the cell file or not
// (an interferometer's air temperature). The kind of device and the unit decide the default.
ChannelLimit limit_of(const CellDescription& cell, const DeviceDescription& device,
                      std::string_view channel);

}  // namespace driftwise::plausibility
