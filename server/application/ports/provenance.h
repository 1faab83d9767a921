#pragma once
// What data rest on: the cell file that they were measured under, the corrections laid over them,
// and what accepting a finding would change. Part of the Cell (cell.h), with its threads.

#include <optional>
#include <string>
#include <vector>

#include "server/application/ports/diagnosis_request.h"
#include "server/core/description/cell_description.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/configuration_records.h"
#include "server/core/records/records.h"
#include "server/formats/cell_file/cell_file_difference.h"

namespace driftwise::application {

struct Caller;

struct ConfigurationView {
  std::string hash, text;
  std::string compared_hash;
  std::vector<formats::ConfigurationChange> changes;  // from this one to the one compared with
};

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
  std::vector<std::string> promotion_questions;
  std::vector<std::string> sentences;  // all of it for people
};

class Provenance {
 public:
  virtual ~Provenance() = default;
  // Starts of the daemon, newest first.
  virtual Awaitable<Result<std::vector<ConfigurationStart>>> configurations(int limit) = 0;
  // Empty hashes: the present one. Errors: not_found NO_SUCH_CONFIGURATION.
  virtual Awaitable<Result<ConfigurationView>> configuration(std::string hash,
                                                             std::string compare_hash) = 0;
  // A person has seen the difference to this configuration. The unfinished run continues, targets
  // are served again. Errors: failed_precondition NO_QUESTION, OTHER_CONFIGURATION (hash is not the
  // present one).
  virtual Awaitable<Result<ConfigurationStart>> accept_configuration(Caller caller,
                                                                     std::string hash,
                                                                     std::string note) = 0;
  // One per run, in order. Errors: not_found NO_SUCH_RUN.
  virtual Awaitable<Result<std::vector<RunGround>>> grounds_of_runs(std::vector<RunId> runs) = 0;
  virtual Awaitable<Result<ModelGround>> ground_of_model(ModelId id) = 0;
  virtual Awaitable<Result<std::vector<CorrectionRecord>>> corrections() = 0;  // oldest first
  // What accept_extension with the same request would do; changes nothing. Errors: its.
  virtual Awaitable<Result<ExtensionPreview>> preview_extension(AcceptRequest request) = 0;
};

}  // namespace driftwise::application
