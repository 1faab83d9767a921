#pragma once
// Keithley 2700 / 2701 scans over SCPI, bytes <-> values. Pure: no I/O, no clock.
//
// Facts and where they come from (M maker's manual, D public driver, U not confirmed):
// - channel lists "(@101:110)", "(@101,103,201:203)" (M); four-wire on a 20-channel card: 101..110
// only (M)
// - FORM:ELEM READ,CHAN,TST gives three fields per channel, joined by ',' on one line (M); the
// order on the wire need not be the
//   order asked for (U): learn_layout finds it by the channel numbers
// - units may be glued to a field: "+2.1E+01C", "+11.664SECS" (M 14-3)
// - overflow, open probe, invalid element = +9.9E37: a reading, no error (M 14-6)
// - SYST:ERR? answers 0,"No error" or -113,"Undefined header" (M)

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/result.h"

namespace driftwise::keithley {

// Runs are written short: {101,102,103,205} -> "(@101:103,205)".
std::string encode_channel_list(std::span<const int> channels);
// Errors: data_loss, BAD_REPLY.
Result<std::vector<int>> parse_channel_list(std::string_view text);

struct DeviceError {
  int number = 0;  // 0: none
  std::string text;
};
Result<DeviceError> parse_device_error(std::string_view reply);

// Which of a channel's fields is what.
struct Layout {
  std::size_t fields = 3, reading = 0, channel = 1, time = 2;
  bool operator==(const Layout&) const = default;
};

struct ChannelReading {
  int channel = 0;
  double value = 0;   // ohms; kMissing for an overflow
  double time_s = 0;  // by the scanner's own clock
};

// The fields of one scan: count values, each a number with or without a unit behind it. Errors:
// data_loss, BAD_REPLY; reason FIELD_COUNT when there are more or fewer than `count`.
Result<std::vector<double>> parse_fields(std::string_view reply, std::size_t count);

// Finds the field that holds exactly the scanned channels; the reading is the first of the two
// others, the time stamp the last (the order of FORM:ELEM in the manual, with or without CHAN
// between). Errors: data_loss, UNKNOWN_LAYOUT.
Result<Layout> learn_layout(std::span<const double> fields, std::span<const int> scanned);

// In the order of the wire. Errors: data_loss, WRONG_CHANNEL when a scanned channel is missing,
// twice or not asked for.
Result<std::vector<ChannelReading>> read_scan(std::span<const double> fields, const Layout& layout,
                                              std::span<const int> scanned);

}  // namespace driftwise::keithley
