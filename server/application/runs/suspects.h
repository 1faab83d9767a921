#pragma once
// Points that rest on an instrument or a zero that was found false: kept out of fits with the mark
// `suspect`, until a person puts them back. Nothing is deleted.

#include <optional>
#include <string>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/ports/awaitable.h"
#include "server/core/result.h"

namespace driftwise::application {

struct ActiveRun;
struct RunBefore;

// The accepted points of this run, and which of them a good closure has confirmed. A run that goes
// on after a restart begins with the points of the line that was under way.
class SinceClosure {
 public:
  void add(std::int64_t row, CellTime measured) { points_.push_back({row, measured}); }
  // What was measured up to now rests on a zero that was found again.
  void close() { confirmed_ = points_.size(); }
  // What has not been confirmed is measured again.
  void drop_open() { points_.resize(confirmed_); }
  // Rows since the last good closure, and those measured after the instant, ascending; each is
  // given once.
  std::vector<std::int64_t> take(CellTime since);
  // Rows measured in the stretch, both instants included, ascending; each is given once.
  std::vector<std::int64_t> take_from(CellTime since, std::optional<CellTime> until);

 private:
  struct Point {
    std::int64_t row;
    CellTime measured;
    bool taken = false;
  };
  std::vector<Point> points_;
  std::size_t confirmed_ = 0;
};

// Marks the points since the last good closure, and those measured from the instant on. On disk
// when it returns. Errors: the store's.
Awaitable<Result<void>> mark_suspects(ActiveRun& run, CellTime since, std::string reason);
// Marks these rows. On disk when it returns. Errors: the store's.
Awaitable<Result<void>> mark_rows(ActiveRun& run, std::vector<std::int64_t> rows,
                                  std::string reason);
// The same for what the devices' answers made suspect meanwhile, if anything.
Awaitable<Result<void>> mark_doubted(ActiveRun& run);

// The points of the line that was under way when the daemon ended: no closure has confirmed them.
void add_line_under_way(ActiveRun& run, const RunBefore& before);
// The comparison of the old zero, which a new datum holds (reference lost, restart), stands for the
// closure of the line under way. Without one, after a lost beam, the next closure decides.
Awaitable<Result<void>> mark_after_datum(ActiveRun& run);

}  // namespace driftwise::application
