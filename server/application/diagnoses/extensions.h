#pragma once
// Extensions: what is made of a diagnosis' findings. Executor's thread.

#include <string>
#include <vector>

#include "server/application/ports/caller.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/configuration_records.h"
#include "server/core/records/diagnosis_records.h"
#include "server/core/result.h"

namespace driftwise::application {

struct AcceptRequest {
  DiagnosisId diagnosis;
  std::vector<int> findings;  // numbers from 1; empty: all
  bool promote = false;       // the model that it makes serves at once
  bool confirmed = false;     // a person has read its promotion questions (provenance.h)
  std::string reason = {};    // why it serves all the same; kept as a note on the model
};

struct ExtensionPreview {
  std::vector<int> findings;
  std::string formula;  // of the model that it makes
  bool extends_model = false;
  std::vector<LengthChange> changes;  // the diagnosed runs first, then by size
  bool earlier_runs = false;          // others than the diagnosed ones change
  bool later_runs = false;            // every run to come does
  std::vector<RowsOfRun> excluded;
  std::vector<std::string> further;  // datums split, thermometers left out: sentences
  std::vector<std::string> promotion_questions, questions_for_a_reason;  // the latter among them
  std::vector<std::string> sentences;                                    // all of it for people
};

class Extensions {
 public:
  virtual ~Extensions() = default;

  // What accept() with the same request would do; changes nothing. Errors: its.
  virtual Awaitable<Result<ExtensionPreview>> preview(AcceptRequest request) = 0;
  // Makes of the findings what they apply to: extension_plan.h. Errors: failed_precondition
  // NOT_DONE, NOTHING_FOUND, INDISTINGUISHABLE (a set without a choice), FROM_A_FILE,
  // OUTPUTS_DISAGREE, IMPOSSIBLE_PARAMETER (instrument_agreement.h); with promote
  // NEEDS_CONFIRMATION, REASON_REQUIRED (Promotions::promote); those of fit(); already_exists
  // EXTENSION_STANDS. All of it is stored in one transaction.
  virtual Awaitable<Result<ExtensionRecord>> accept(Caller caller, AcceptRequest request) = 0;
  virtual Awaitable<Result<ExtensionRecord>> undo(Caller caller, DiagnosisId id) = 0;
};

}  // namespace driftwise::application
