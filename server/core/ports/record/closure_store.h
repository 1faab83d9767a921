#pragma once
// Returns to zero as they were judged: a part of server/core/ports/store.h, with its thread and its
// errors.

#include <optional>
#include <vector>

#include "server/core/records/closure_records.h"
#include "server/core/result.h"

namespace driftwise {

class ClosureStore {
 public:
  virtual ~ClosureStore() = default;
  // Durable when it returns, in one transaction. With a repeated line: its points leave the
  // datasets, its rows may have a point again, marks of the daemon on them are taken back, and the
  // run stands at its place. Answers with the record's id. Errors: not_found NO_SUCH_RUN.
  virtual Result<std::int64_t> add_closure(const ClosureRecord& closure,
                                           const std::optional<RepeatedLine>& repeated) = 0;
  // Of a run, oldest first.
  virtual Result<std::vector<ClosureRecord>> closures(RunId run) = 0;
  // Points of the run whose line was measured again, ascending.
  virtual Result<std::vector<PointId>> repeated_points(RunId run) = 0;
};

}  // namespace driftwise
