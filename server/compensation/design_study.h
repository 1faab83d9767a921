#pragma once
// A design study: the uncertainty that a model's targets would have with other instruments, lever
// arms or material, from the budget of today's cell and the model run over its own rows. Pure. What
// it takes as unchanged, and what that means: docs/uncertainty.md, Another design.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/calibration/model/model.h"
#include "server/compensation/design_quantities.h"
#include "server/compensation/model_budget.h"
#include "server/core/data/dataset.h"

namespace driftwise::compensation {

struct DesignLine {
  UncertaintySource source = UncertaintySource::fit;
  double u_before_nm = 0, u_after_nm = 0;
};

struct DesignOutput {
  std::string place;  // of budget_places
  Channel channel;    // q1_mm
  std::vector<DesignLine> lines;
  double u90_before_nm = 0, u90_after_nm = 0;
  // Of a model without terms of temperature: what today's terms of temperature take away over the
  // rows, rms about its mean, in squares with the rest. None: there are none, or no rows.
  std::optional<double> u90_uncompensated_before_nm, u90_uncompensated_after_nm;
  const DesignLine* largest(double DesignLine::*u) const;  // nullptr: no lines
};

struct DesignChange {
  std::string what;  // "x.u_length_nm"
  double before = 0, after = 0;
};

struct DesignStudy {
  std::vector<DesignChange> changes;
  std::vector<BudgetPlace> places;
  std::vector<DesignOutput> outputs;       // place by place
  std::vector<std::string> not_answered;   // sentences
  std::vector<DesignQuantity> quantities;  // what can be changed
};

// changes: "x.u_length_nm=2"; "*.u_length_nm=2" for every subject with that key. rows: of the fit;
// nullptr: they are not known. Errors: those of SnapshotBuilder::create; invalid_argument
// UNKNOWN_NAME (naming what can be changed), BAD_NUMBER; failed_precondition of a place that the
// model refuses.
Result<DesignStudy> study_design(const calibration::Model& model, const CellDescription& cell,
                                 std::span<const std::string> changes, const Dataset* rows);

}  // namespace driftwise::compensation
