#pragma once
// Datasets: loaded for a fit, exported, imported. Executor's thread.

#include <optional>
#include <string>
#include <vector>

#include "server/application/ports/caller.h"
#include "server/core/data/dataset.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/records.h"
#include "server/core/result.h"
#include "server/correction/join_part.h"

namespace driftwise::application {

struct JoinRequest {
  std::vector<RunId> runs;
  std::string name = {};  // empty: "join of runs 3, 4, 5"
  correction::JoinRules rules = {};
  bool dry_run = false;  // reports, stores nothing
  std::string request_id = {};
};
struct JoinAnswer {
  std::optional<RunRecord> run;  // none: a dry run
  std::string report_json;       // driftwise.join.v1
};

class Datasets {
 public:
  virtual ~Datasets() = default;

  // Of runs, with the corrections in force, or of a CSV text: one of the two. Errors:
  // invalid_argument NO_DATA; those of amended_dataset and read_dataset_csv.
  virtual Awaitable<Result<Dataset>> load(std::vector<RunId> runs, std::string csv) = 0;
  // Per row of load() of the same: "calibration", "validation" or the name of its validation set
  // (server/formats/csv/set_names.h). Empty: no set has a name, or they cannot be told. Errors:
  // those of load().
  virtual Awaitable<Result<std::vector<std::string>>> set_names(std::vector<RunId> runs,
                                                                std::string csv) = 0;
  // CSV text. Rows kept out of fits are marked in a column, or left out.
  virtual Awaitable<Result<std::string>> export_csv(std::vector<RunId> runs,
                                                    bool without_excluded) = 0;
  // Becomes a run, done. The same request_id again answers with the first run.
  virtual Awaitable<Result<RunRecord>> import_csv(Caller caller, std::string name, std::string csv,
                                                  std::string request_id) = 0;
  // Runs of one trajectory in different set-ups as one dataset, which becomes a run, done
  // (docs/joined-runs.md). Errors: those of join_parts and correction::join.
  virtual Awaitable<Result<JoinAnswer>> join(Caller caller, JoinRequest request) = 0;
};

}  // namespace driftwise::application
