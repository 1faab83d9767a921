#pragma once
// Models: fitted, looked at. Fits run on the worker pool. Executor's thread.

#include <string>
#include <vector>

#include "server/application/models/fit_request.h"
#include "server/application/models/formula_check.h"
#include "server/application/models/kinematic_record.h"
#include "server/application/models/model_list.h"
#include "server/application/ports/caller.h"
#include "server/calibration/offer.h"
#include "server/core/channel.h"
#include "server/core/data/dataset.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/records.h"
#include "server/core/result.h"
#include "server/correction/data_amendment.h"

namespace driftwise::application {

// Residuals of a model on the rows of a dataset. Rows of a run that it was fitted to are in the
// datum that they had in the fit, whichever runs are asked for. Rows of another run count from the
// values of their zero, as the check standard has them (diagnosis/check/check_errors.h): what the
// model says of the way from there. Rows of a text are counted as a fit of that text would.
struct ModelResiduals {
  struct Output {
    Channel channel;               // q1_mm
    std::vector<double> values;    // measured minus model, summary unit; NaN: cannot be said
    std::vector<double> held_out;  // as OutputModel::held_out, summary unit; empty: other rows
  };
  Dataset data;
  std::vector<Output> outputs;
  std::string dataset_hash;
  std::vector<std::string> sets;  // Datasets::set_names
  bool same_rows = false;         // the very dataset that the model was fitted to
  // Runs that the model was not fitted to and of which a zero is not known: the mean of the rows of
  // each of their datums is taken out, as a fit would do.
  std::vector<RunId> mean_taken_out = {};
  // Run and row of its plan, one per row: what a person is told and what rows are kept out by.
  // Empty: rows of a text.
  std::vector<correction::RowOrigin> origins = {};
};

class Models {
 public:
  virtual ~Models() = default;

  virtual Awaitable<Result<ModelRecord>> fit(Caller caller, FitRequest request) = 0;
  // Stores a robot's geometry as a model. Errors: those of fit() and kinematic_record().
  virtual Awaitable<Result<KinematicFit>> create_kinematic(Caller caller,
                                                           KinematicRequest request) = 0;
  // What the published study's further terms would add to the same fit. Errors: those of fit().
  virtual Awaitable<Result<std::vector<calibration::OfferResult>>> weigh_offers(
      FitRequest request) = 0;
  // Errors: of the data only; what is wrong with the formula is the answer.
  virtual Awaitable<Result<FormulaCheck>> check_formula(FitRequest request) = 0;
  // runs and csv empty: the runs that it was fitted to. Errors: not_found; failed_precondition
  // NO_ROWS (it was fitted to a file); invalid_argument UNKNOWN_CHANNEL, UNTIMED.
  virtual Awaitable<Result<ModelResiduals>> residuals(ModelId model, std::vector<RunId> runs,
                                                      std::string csv) = 0;
  // A damaged one is listed with its damage, and is an error by itself.
  virtual Awaitable<Result<std::vector<ListedModel>>> list() = 0;
  virtual Awaitable<Result<ModelRecord>> get(ModelId id) = 0;
};

}  // namespace driftwise::application
