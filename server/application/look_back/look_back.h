#pragma once
// Looking back: stability of a channel, runs side by side, remarks at an instant. Executor's
// thread.

#include <optional>
#include <string>
#include <vector>

#include "server/application/ports/caller.h"
#include "server/core/cell_time.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/records.h"
#include "server/core/result.h"
#include "server/stability/allan.h"
#include "server/stability/spectrum.h"

namespace driftwise::application {

struct Stability {
  std::string channel, unit;  // of the deviations: "nm" for lengths, "mK" for temperatures
  CellTime from, to;          // of the stretch that was used
  std::int64_t used = 0, all = 0;
  double interval_s = 0;
  std::vector<stability::AllanPoint> allan;
  std::vector<stability::SpectrumPoint> spectrum;
  std::string sentence;
};

struct ComparedSeries {
  std::string name, unit;
  std::vector<double> hours, values;  // since the run's start; change since the first value
  double mean = 0, range = 0;
  std::optional<double> rate_per_h;
};

struct ComparedRun {
  RunRecord run;
  std::vector<ComparedSeries> zero, temperatures, residuals;
  std::string residual_trouble;
};

class LookBack {
 public:
  static constexpr std::size_t kMostRuns = 8;

  virtual ~LookBack() = default;
  // Errors: invalid_argument BAD_RANGE; not_found NO_SUCH_CHANNEL; failed_precondition
  // TOO_FEW_SAMPLES.
  virtual Awaitable<Result<Stability>> stability_of(std::string channel, CellTime from,
                                                    CellTime to) = 0;
  // Errors: those of Datasets::load; invalid_argument BAD_COUNT.
  virtual Awaitable<Result<std::vector<ComparedRun>>> compare(std::vector<RunId> runs,
                                                              std::optional<ModelId> model) = 0;
  // Errors: invalid_argument BAD_SUBJECT (no text, or a channel that this cell has not).
  virtual Awaitable<Result<TimeNoteRecord>> add_note(Caller caller, TimeNoteRecord note) = 0;
};

}  // namespace driftwise::application
