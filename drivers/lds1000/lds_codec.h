#pragma once
// The LDS1000 controller of an LDS-Vector autocollimator (manual EDH0170, 09/98; PROTOCOLS.md
// section 2), bytes <-> values. Pure.
//
//   VE    VE LDS1000 Controller Version 3.10
//   1TA   1TA,RT,04512,1,<micro>rad,00102,00241    set-up: type, coefficient, increment, unit, two
//                                                  offsets
//   1TP   1TP-1596.3                               present value of axis 1 in the set-up's unit
//   MS    MS@                                      status character, bit 6 always set
//   TE    TE@                                      last error, cleared by reading it
//   XI    XI100                                    integration constant, ms
//
// Replies repeat the command. Setters (KI<ms>) answer nothing: TE says whether one was taken. The
// micro sign is one byte outside ASCII (0xB5 or 0xE6), and the increment may be printed with a
// decimal comma, which is the separator too: the set-up is read from both of its ends.

#include <string>
#include <string_view>

#include "server/core/result.h"

namespace driftwise::lds1000 {

enum class Unit { arcsec, microradian };
const char* name_of(Unit unit);  // "sec", "urad": as the option spells it
double arcsec_from(double value, Unit unit);

struct SetUp {
  Unit unit = Unit::arcsec;
  double increment = 0;  // of the display, in its own counting: 0.2 is 0.02 arcsec
  bool operator==(const SetUp&) const = default;
};

struct Status {
  bool wrong_power = false;     // too much or too little light comes back
  bool wrong_position = false;  // the spot is outside the detector's range
  bool usable() const { return !wrong_power && !wrong_position; }
};

// One reply line with or without its end. Errors: data_loss BAD_REPLY, saying what was expected;
// failed_precondition UNKNOWN_UNIT (parse_set_up: neither seconds of arc nor microradian).
Result<std::string> parse_version(std::string_view reply);  // "LDS1000 Controller Version 3.10"
Result<SetUp> parse_set_up(std::string_view reply, int axis);
Result<double> parse_value(std::string_view reply, int axis);
Result<Status> parse_status(std::string_view reply);
Result<int> parse_integration_ms(std::string_view reply);

// The answer to TE. Errors: BAD_REPLY; what the device holds against the last command:
// invalid_argument BAD_AXIS (B), BAD_PARAMETER (C, O); failed_precondition NOT_NOW (D);
// deadline_exceeded DEVICE_TIMEOUT (S); internal UNKNOWN_COMMAND (A).
Result<void> parse_error(std::string_view reply);

}  // namespace driftwise::lds1000
