#pragma once
// Commissioning: every device against what the cell file expects, thermometers side by side, a cell
// at rest. Executor's thread. Nothing here moves an axis.

#include <optional>
#include <string>
#include <vector>

#include "server/application/ports/caller.h"
#include "server/core/cell_time.h"
#include "server/core/description/certificate_description.h"
#include "server/core/ports/awaitable.h"
#include "server/core/result.h"
#include "server/stability/thermometers.h"

namespace driftwise::application {

enum class Finding { good, warning, bad, unknown };  // unknown: nothing is declared

struct CheckItem {
  std::string device, asked, found, expected;
  Finding finding = Finding::good;
  std::string advice;  // what to do; empty: nothing
};

struct CellCheck {
  CellTime at;
  std::vector<CheckItem> items;  // in the order of the devices
  Finding worst() const;         // unknown does not count
};

struct RestLimits {
  double length_nm_per_h = 20, temperature_k_per_h = 0.05, window_s = 1800;
};

struct RestChannel {
  std::string channel, unit, change_unit;  // "nm/h", "nm"
  std::optional<double> rate, u_rate;      // over the last window
  double limit = 0, change = 0;            // change: since the rest began
  std::optional<CellTime> warm;
};

struct RestReport {
  CellTime begin, end;  // end 0: under way
  std::string begun_by, end_reason;
  RestLimits limits;
  std::vector<RestChannel> channels;
  std::optional<CellTime> warm;  // all channels
  std::string sentence;          // "warm since 03:10"
};

struct ThermometerReport {
  CellTime from, to;
  std::int64_t scans = 0;
  bool quiet = false;
  stability::ThermometerComparison comparison;
};

struct CertificateState {
  CertificateDescription certificate;
  std::optional<std::int64_t> days_left;  // below 0: overdue
};

class Commissioning {
 public:
  // Common drift of the thermometers up to which a stretch is quiet.
  static constexpr double kQuiet_k_per_h = 0.1;

  virtual ~Commissioning() = default;
  virtual Awaitable<CellCheck> check(Caller caller) = 0;
  // from, to: of the record; channels empty: all probes. Errors: invalid_argument BAD_RANGE,
  // BAD_CHANNEL; failed_precondition TOO_FEW_SAMPLES.
  virtual Awaitable<Result<ThermometerReport>> compare_thermometers(
      CellTime from, CellTime to, std::vector<std::string> channels) = 0;
  // A rest lasts until end_rest, a movement or a run; a restart continues it. Errors:
  // failed_precondition RUN_UNDER_WAY, MOVING; invalid_argument BAD_LIMITS.
  virtual Awaitable<Result<void>> begin_rest(Caller caller, RestLimits limits) = 0;
  // Errors of both: not_found NO_REST.
  virtual Awaitable<Result<void>> end_rest(Caller caller) = 0;
  virtual Awaitable<Result<RestReport>> rest() = 0;
  virtual std::vector<CertificateState> certificates() const = 0;
};

}  // namespace driftwise::application
