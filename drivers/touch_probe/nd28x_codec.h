#pragma once
// Read-out Heidenhain ND 28x of a touch probe, RS-232 (manuals of the ND 281B and the ND 287;
// PROTOCOLS.md section 5), bytes <-> values. Pure.
//
//   02            +   1.23450  =A CR LF   present value, latched in 1 ms, sent within 50 ms (M)
//   ESC A0000 CR  STX and three lines     identity (M: lines of 10 characters; U: their content)
//
// A value is 17 characters (M: ND 281B page 47, ND 287 page 115):
//
//   sign; 10 characters of number; blank; unit; sorting; series; CR LF
//   unit      blank mm, " inch, ? fault; ND 287: G deg, M deg-min-sec, R rad, m mm/min, i inch/min,
//             U rev/min
//   sorting   < = > ? or blank
//   series    S MIN, A present value, G MAX, D DIFF or blank; ND 287 with two axes and without a
//             series: 1 X1, 2 X2, A X1 + X2, S X1 - X2, F a function of both
//
// Where the read-out shows a message in the place of a value, what it sends is not described (U): a
// line without digits is taken as that message. A command that it does not know is answered with 15
// (NAK), without a line end (M).
// M: maker's document. U: unconfirmed.

#include <string>
#include <string_view>

#include "server/core/result.h"

namespace driftwise::touch_probe {

inline constexpr const char* kAskValue = "\x02";
inline constexpr const char* kAskIdentity =
    "\x1b"
    "A0000\r";
inline constexpr int kIdentityLines = 3;

// Value in mm: unit mm, series blank, A or 1, any sorting. Errors: failed_precondition WRONG_SET_UP
// (another unit or series), INPUT_ERROR (it shows a message, or marks the value as faulty);
// data_loss BAD_REPLY.
Result<double> parse_value(std::string_view reply);

// The three lines as one: "ND 287, 123 456 78, V1.02". Errors: data_loss BAD_REPLY;
// failed_precondition WRONG_DEVICE.
Result<std::string> parse_identity(std::string_view reply);

}  // namespace driftwise::touch_probe
