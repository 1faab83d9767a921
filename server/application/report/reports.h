#pragma once
// Report of a run: everything that the record says of it, as one page (docs/web-report.md).
// Executor's thread.

#include <string>

#include "server/core/ids.h"
#include "server/core/ports/awaitable.h"
#include "server/core/result.h"

namespace driftwise::application {

class Reports {
 public:
  virtual ~Reports() = default;
  // HTML of one file, made now. Errors: not_found NO_SUCH_RUN; failed_precondition NO_WEB_PAGE (no
  // template is installed), BAD_TEXT (it is another program's); those of the store.
  virtual Awaitable<Result<std::string>> page(RunId run) = 0;
};

// "cell.db" -> "reports/queue-4-run-12.html" in the same folder.
std::string report_path(const std::string& database, QueueEntryId entry, RunId run);

// Under its name whole, or not at all; makes the folder. Blocks. Errors: internal CANNOT_WRITE.
Result<void> write_report(const std::string& path, const std::string& text);

}  // namespace driftwise::application
