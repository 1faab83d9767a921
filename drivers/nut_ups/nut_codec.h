#pragma once
// Text protocol of upsd (Network UPS Tools, RFC 9271 and its network protocol document), bytes <->
// values. Pure.
//
//   VER                      Network UPS Tools upsd 2.8.0 - http://www.networkupstools.org/
//   GET VAR <ups> <name>     VAR <ups> <name> "<value>"       or ERR <word>
//
// ups.status is a list of words: OL on line, OB on battery, LB low battery, FSD it is about to
// switch off, CHRG, DISCHRG, RB replace battery, CAL calibrating, ... Unknown words are left out.

#include <optional>
#include <string>
#include <string_view>

#include "server/core/result.h"

namespace driftwise::nut_ups {

// True for the answer to VER.
bool is_version(std::string_view line);

std::string get_command(std::string_view ups, std::string_view name);  // without a line end

// The value of the answer to GET VAR; none: the UPS has no such variable (VAR-NOT-SUPPORTED).
// Errors: data_loss BAD_REPLY; failed_precondition UPS_NOT_THERE (UNKNOWN-UPS), UPS_STALE
// (DATA-STALE, DRIVER-NOT-CONNECTED: upsd answers and its driver does not), ACCESS_DENIED.
Result<std::optional<std::string>> parse_value(std::string_view line, std::string_view ups,
                                               std::string_view name);

struct Supply {
  bool on_battery = false;  // OB
  // Power is about to go: LB while on battery, or FSD without OL. A battery that is charged after a
  // power cut is low as well, and mains are there: OL CHRG LB.
  bool low_battery = false;
};
// Errors: data_loss BAD_REPLY: neither OL nor OB, nor another word that says where power comes
// from; failed_precondition UPS_STALE: WAIT, upsd has not heard of the UPS yet.
Result<Supply> parse_status(std::string_view status);

// A number from 0 up. Errors: data_loss BAD_REPLY.
Result<double> parse_quantity(std::string_view text, std::string_view name);

}  // namespace driftwise::nut_ups
