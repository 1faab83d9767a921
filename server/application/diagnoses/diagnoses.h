#pragma once
// Diagnoses: created, looked at, cancelled, watched. They run on a thread of their own; created
// ones answer at once. Executor's thread.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/application/diagnoses/diagnosis_progress.h"
#include "server/application/ports/caller.h"
#include "server/core/ports/awaitable.h"
#include "server/correction/data_amendment.h"

namespace driftwise::application {

struct DiagnosisRequest {
  std::vector<RunId> runs;
  std::string csv;               // instead of runs: a dataset as text
  std::string baseline;          // formula; empty: that of the model, or of the one that serves
  std::optional<ModelId> model;  // the simulation it begins from
  double alpha = 0.003;
  std::int64_t seed = 1;
  std::vector<std::string> exclude_symbols;
  std::string name;
  // Of a cell with several robots: "ma". Empty: the one that the baseline's outputs name.
  std::string robot = {};
};

struct DiagnosisView {
  DiagnosisRecord record;
  std::optional<diagnosis::Diagnosis> found;  // once it is done; without the rows' residuals
  std::optional<ExtensionRecord> extension;   // the last one that was accepted, undone or not
  // Run and row of its plan by place in the dataset, where a finding names rows of runs. Of get().
  std::vector<correction::RowOrigin> origins = {};
};

class Diagnoses {
 public:
  virtual ~Diagnoses() = default;

  // Errors: invalid_argument (formula, channel, NO_DATA, what diagnosis::diagnose refuses before it
  // searches; those of formats::robot_asked_for); failed_precondition NO_MODEL (no baseline and
  // nothing serves); not_found.
  virtual Awaitable<Result<DiagnosisView>> create(Caller caller, DiagnosisRequest request) = 0;
  virtual Awaitable<Result<DiagnosisView>> get(DiagnosisId id) = 0;
  virtual Awaitable<Result<std::vector<DiagnosisView>>> list() = 0;  // newest first
  virtual Awaitable<Result<DiagnosisView>> cancel(Caller caller, DiagnosisId id) = 0;
  // Of every diagnosis until the handle is destroyed; at once of those under way.
  virtual std::shared_ptr<void> watch(std::function<void(const DiagnosisProgress&)> on_change) = 0;
};

}  // namespace driftwise::application
