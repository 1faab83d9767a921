#pragma once
// The text lines of the interferometer adapter (our own definition, PROTOCOLS.md section 3), bytes
// <-> values. Pure.
//
//   IDN?            OK <maker> <model> <serial> ch=3
//   AVG 4096        OK                  2048 | 4096 | 8192 | 16384
//   DEADPATH 1 120  OK                  channel, mm; before ZERO
//   ZERO 1          OK                  mask of channels: bit 0 is channel 1
//   MEAS? 1         OK ch=1 n=4096 mean_nm=<f> std_nm=<f> t_air_C=<f> t_age_s=<f> level_pct=<f>
//   status=0x0010
//                      t0=<unix> t1=<unix>
//   anything        ERR <code> <text>   1 syntax, 2 no device, 3 beam break, 4 time-out, 5
//   overflow, 6 laser unstable
//
// Status bits as the maker's library has them (IfmStatus): 0x01 quadrant jump, 0x02 low level, 0x10
// laser stable, 0x20 was unstable since zero, 0x100 device overflow, 0x200 library overflow, 0x8000
// bad request.
//
// The adapter has corrected the refractive index of air already (on by default in the maker's
// library): nobody corrects the length a second time. t_air_C is reported for the record and for
// models of the dead path.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "server/core/cell_time.h"
#include "server/core/result.h"

namespace driftwise::adapter {

struct Identity {
  std::string text;  // "SIOS SP-2000 0471"
  int channels = 0;
};

struct Measurement {
  int channel = 0;
  int samples = 0;
  double mean_nm = 0, std_nm = 0;
  double air_degc = 0, air_age_s = 0;
  double level_pct = 0;
  std::uint32_t status = 0;
  CellTime start, end;  // the device's clock; read without loss to the nanosecond
};

// One reply line with or without its end. Errors: data_loss, BAD_REPLY (says which field is missing
// or wrong); for "ERR <code> <text>": failed_precondition BEAM_LOST (3), LASER_UNSTABLE (6),
// NO_DEVICE (2); data_loss VALUES_LOST (5); deadline_exceeded DEVICE_TIMEOUT (4); internal SYNTAX
// (1).
Result<Identity> parse_identity(std::string_view reply);
Result<void> parse_ok(std::string_view reply);
Result<Measurement> parse_measurement(std::string_view reply);

// What the status bits say about the length. Errors: failed_precondition BEAM_LOST (quadrant jump),
// LASER_UNSTABLE (now, or since zero), LOW_LEVEL; data_loss VALUES_LOST (overflow); internal
// BAD_REQUEST.
Result<void> check_status(const Measurement& measurement);

// "1795248299.123456789" -> nanoseconds, exactly. Digits beyond the ninth are cut.
std::optional<CellTime> parse_unix_time(std::string_view text);

}  // namespace driftwise::adapter
