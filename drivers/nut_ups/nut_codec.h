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
  // LB while on battery. A battery that is charged after a power cut is low as well, and mains are
  // there: OL CHRG LB. A runtime calibration (CAL) discharges the battery on purpose: as upsmon
  // (is_ups_critical), OB CAL LB is not taken as low.
  bool low_battery = false;
  // FSD: upsd has announced a forced shutdown. It brings down a computer whose supply is otherwise
  // well, and is not taken back when mains return (upsmon(8), "Forced shutdowns"): upsd keeps the
  // word until it is started anew.
  bool forced = false;
  bool on_mains = false;  // OL
};
// Errors: data_loss BAD_REPLY: neither OL nor OB, nor another word that says where power comes
// from; failed_precondition UPS_STALE: WAIT, upsd has not heard of the UPS yet.
Result<Supply> parse_status(std::string_view status);

// Whether power is about to go, by one supply's statuses since the start. A forced shutdown that
// was there at the first one, beside mains, is left over from before: acted on, it would end the
// daemon each time it is started.
class AboutToGo {
 public:
  // True: LB while on battery, without CAL; FSD, whatever stands beside it, that began since the
  // start; an older one that is no longer beside mains.
  bool take(const Supply& supply);

 private:
  bool seen_ = false;
  bool is_old_ = false;  // the forced shutdown that stands was there at the first status
};

// A number from 0 up. Errors: data_loss BAD_REPLY.
Result<double> parse_quantity(std::string_view text, std::string_view name);

}  // namespace driftwise::nut_ups
