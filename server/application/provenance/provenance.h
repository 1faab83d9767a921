#pragma once
// Provenance of data: the cell files they were measured under, the corrections applied to them.
// Executor's thread.

#include <optional>
#include <string>
#include <vector>

#include "server/core/description/cell_description.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/configuration_records.h"
#include "server/core/records/diagnosis_records.h"
#include "server/core/records/records.h"
#include "server/core/result.h"
#include "server/formats/cell_file/cell_file_difference.h"

namespace driftwise::application {

struct RunGround {
  std::vector<UsedConfiguration> configurations;  // oldest first
  std::vector<CorrectionRecord> corrections;      // in force over its data; changes: of this run
};

struct ModelGround {
  // Of its runs, before it was fitted, oldest first, each once; empty: a file.
  std::vector<UsedConfiguration> configurations;
  std::optional<CellDescription> measured_under;  // the last of them; none: it cannot be read
  std::string present_hash;
  std::vector<formats::ConfigurationChange> changes_since;  // from it to the present one
  std::vector<CorrectionRecord>
      corrections;  // that it rests on, in force or not; changes: of its runs
  // What a person has to answer before it serves: sentences.
  std::vector<std::string> promotion_questions;
  // Those of them that a reason in writing answers.
  std::vector<std::string> questions_for_a_reason;
};

class Provenance {
 public:
  virtual ~Provenance() = default;
  // One per run, in order. Errors: not_found NO_SUCH_RUN.
  virtual Awaitable<Result<std::vector<RunGround>>> grounds_of_runs(std::vector<RunId> runs) = 0;
  virtual Awaitable<Result<ModelGround>> ground_of_model(ModelId id) = 0;
};

}  // namespace driftwise::application
