#pragma once
// Digital protractor MEAS DPL2, a two-axis inclinometer (data sheet 07/2015; PROTOCOLS.md section
// 6), bytes <-> values. Pure.
//
//   s   s                                  stops the stream; the byte comes back (M)
//   V   DPL2 V1.8.0<CRLF>SN:12345678<CRLF>  identity, two lines (M)
//   R   X=+01.234<CRLF>Y=-00.007<CRLF>      one pair in degrees; only while stopped (M)
//   S                                      stream, the state after power on (M)
//
// Commands are one byte without an end; a byte that it does not know gets no answer (M). Whether
// the echo of s has a line end of its own is not said (U): an echo in front of a line is left out.
// Readings beyond the range are not described (U): a value beyond the option range_deg is refused.
// M: maker's document. U: unconfirmed.

#include <string>
#include <string_view>

#include "server/core/result.h"

namespace driftwise::inclinometer {

// True for the last line of the identity: nothing else begins with SN:.
bool ends_identity(std::string_view line);

// Both lines of the answer to V: "DPL2 V1.8.0, SN:12345678". Errors: data_loss BAD_REPLY;
// failed_precondition WRONG_DEVICE.
Result<std::string> parse_identity(std::string_view reply);

struct Tilt {
  double x_deg = 0, y_deg = 0;
};
// Both lines of the answer to R. Errors: data_loss BAD_REPLY.
Result<Tilt> parse_tilt(std::string_view reply);

}  // namespace driftwise::inclinometer
