#pragma once
// The lies of a device, channel by channel: what is said instead of the truth, from which size on
// it must be found, and why some cannot be.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "server/core/description/cell_description.h"
#include "tests/support/plant_cell.h"

namespace driftwise::lies {

enum class Kind : std::uint8_t {
  constant,
  inverted,
  jump,
  scale,
  unit,
  late,
  other,  // another channel's answer
  nan,
  inf,
  huge,
  out_of_range,
};
inline constexpr std::array kKinds = {
    Kind::constant, Kind::inverted, Kind::jump, Kind::scale, Kind::unit,        Kind::late,
    Kind::other,    Kind::nan,      Kind::inf,  Kind::huge,  Kind::out_of_range};
std::string name_of(Kind kind);
bool has_size(Kind kind);
// Must be found within 10 s of the first false answer; the rest at the next closure.
bool is_impossible(Kind kind);

enum class What : std::uint8_t {
  motor,
  length,
  angle,
  part,
  air,
  support,
  set_point,
  share,
  force
};

struct ChannelOfCell {
  std::string name, device;
  What what = What::share;
  std::string other;  // another channel that could answer instead; empty: none
};
// Every channel that the cell's devices give.
std::vector<ChannelOfCell> channels_of(const CellDescription& cell);

// A slow channel that froze is found by the number of its equal answers: the next closure may come
// before.
bool takes_answers(const ChannelOfCell& channel, Kind kind);

// In the channel's unit, for scale its share, for late seconds: from the declared limit. value: the
// true one now. None: no size is ever found.
std::optional<double> expected_size(const CellDescription& cell, const ChannelOfCell& channel,
                                    Kind kind, double value);
// Why a lie of this kind cannot be found on this channel as it is now; empty: it must be.
std::string why_not(const tests::PlantWorld& world, const CellDescription& cell,
                    const ChannelOfCell& channel, Kind kind);
// How far a value in a point may be from the truth before the point is false.
double tolerance(const ChannelOfCell& channel);

// world: outlives the lie.
tests::Liar::Lie make_lie(const tests::PlantWorld& world, const CellDescription& cell,
                          const ChannelOfCell& channel, Kind kind, double size);

}  // namespace driftwise::lies
