#pragma once
// Annotations of the record: rows kept out of fits, and notes. Executor's thread.

#include <cstdint>
#include <string>
#include <vector>

#include "server/application/ports/caller.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/records.h"
#include "server/core/result.h"

namespace driftwise::application {

// Which rows of a run are kept out of fits, and how it came to that.
struct ExclusionState {
  RunId run;
  std::vector<std::int64_t> rows;          // out now, ascending
  std::vector<std::int64_t> suspect_rows;  // those of them that the daemon marked as suspect
  std::string hash;                      // of the run's dataset, as in Lineage; empty: none is out
  std::vector<ExclusionRecord> history;  // oldest first
};

class Annotations {
 public:
  virtual ~Annotations() = default;

  // Keeps rows of a run out of every fit from now on (excluded), or puts them back. The points stay
  // as they were. Rows that are so already change nothing. Errors: not_found NO_SUCH_RUN;
  // invalid_argument NO_SUCH_ROW (no accepted point in it; nothing changes then).
  virtual Awaitable<Result<ExclusionState>> exclude_rows(Caller caller, ExclusionRecord wanted) = 0;
  virtual Awaitable<Result<ExclusionState>> exclusions(RunId run) = 0;
  virtual Awaitable<Result<NoteRecord>> add_note(Caller caller, NoteSubject on,
                                                 std::string text) = 0;
};

}  // namespace driftwise::application
