#pragma once
// What clients ask of diagnosis and improvement, and what they are told: the words of cell.h for
// these two.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/core/data/dataset.h"
#include "server/core/records/diagnosis_records.h"
#include "server/core/result.h"
#include "server/diagnosis/diagnosis.h"

namespace driftwise::application {

// diagnosis::diagnose, or what a test has instead.
using Diagnose =
    std::function<Result<diagnosis::Diagnosis>(const Dataset&, const diagnosis::DiagnoseOptions&)>;

struct DiagnosisRequest {
  std::vector<RunId> runs;
  std::string csv;               // instead of runs: a dataset as text
  std::string baseline;          // formula; empty: that of the model, or of the one that serves
  std::optional<ModelId> model;  // the simulation it begins from
  double alpha = 0.003;
  std::int64_t seed = 1;
  std::vector<std::string> exclude_symbols;
  std::string name;
};

struct DiagnosisView {
  DiagnosisRecord record;
  std::optional<diagnosis::Diagnosis> found;  // once it is done; without the rows' residuals
  std::optional<ExtensionRecord> extension;   // the last one that was accepted, undone or not
};

struct DiagnosisProgress {
  DiagnosisId id;
  JobState state = JobState::running;
  std::string step;     // "looking for a second cause in q1"
  double fraction = 0;  // 0 to 1, never backwards
};

struct AcceptRequest {
  DiagnosisId diagnosis;
  std::vector<int> findings;  // numbers from 1; empty: all
  bool promote = false;       // the model that it makes serves at once
  bool confirmed = false;     // a person has read its promotion questions (provenance.h)
};

struct ImproveRequest {
  std::string lease_token;
  std::string trajectory_name, trajectory_text;
  std::string formula;  // of the first model; empty: the model that serves
  int max_turns = 5;
  double budget_s = 0;  // of cell time; 0: no limit
  // A model whose gain fresh points have shown serves. Else it is proposed, and a person promotes
  // it.
  bool promotes = false;
  std::string request_id;
};

struct ImprovementProgress {
  ImprovementId id;
  JobState state = JobState::running;
  int turn = 0;
  std::string step;  // "measuring 40 fresh points"
};

}  // namespace driftwise::application
