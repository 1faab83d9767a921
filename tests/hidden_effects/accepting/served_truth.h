#pragma once
// Acceptance of a diagnosis and judgement of the served target by the truth.
//
// The findings are accepted by the code that the daemon accepts with (application/diagnoses), the
// model is served by the code that serves (compensation), and the target is asked for the poses
// where the end-effector really was. The robots of two generators that share no code are judged
// here: the plants, and the independent population.

#include <cstdint>
#include <string>
#include <vector>

#include "server/application/diagnoses/extension_plan.h"
#include "server/calibration/model/model.h"
#include "server/compensation/snapshot.h"
#include "server/core/cell_time.h"
#include "server/core/data/dataset.h"
#include "server/core/description/cell_description.h"
#include "server/core/result.h"
#include "server/diagnosis/answer/diagnosis.h"

namespace driftwise::hidden {

// Rows of a campaign with the truth about them. Every vector has one entry per row of the data.
struct TrueRows {
  CellTime time_zero;          // of time_s
  std::vector<double> time_s;  // known here where the data have no times, too
  // Poses of the end-effector in the frame of the instruments' zero: mm, arcsec, N.
  struct Asked {
    compensation::Variable variable;
    std::vector<double> values;
  };
  std::vector<Asked> asked;
  // Motor coordinates there, in order of the model's outputs.
  std::vector<std::vector<double>> motor_mm;
  std::vector<std::uint8_t> judged;  // 1: a row that took no part in the fit
  // Motor coordinates at pose 0, to anchor the datum at the first row. Empty: the data's own
  // (first) datum is the present one, and the target keeps the model's constant.
  std::vector<double> zero_motor_mm;
};

// Served target minus true motor coordinate of the judged rows, in time order.
struct ServedErrors {
  std::vector<std::vector<double>> nm;  // per output
  // 1: the target carries no OUTSIDE_DOMAIN for the pose or the force.
  std::vector<std::uint8_t> inside;
};

// Data with the origin of their rows, as the daemon has them of its runs.
application::RunsData as_runs(const Dataset& data, CellTime time_zero);

// Model of a formula, fitted as the daemon fits what it accepts. Errors: those of
// application::fit_record.
Result<calibration::Model> accepted_fit(const Dataset& data, const std::string& formula);

struct AcceptedModel {
  application::ExtensionPlan plan;
  calibration::Model model;
};

// All findings that the daemon makes without being told whose deviation they are, but corrections
// that are known too badly. Errors: failed_precondition NOTHING_FOUND (no finding can be accepted),
// INDISTINGUISHABLE (every finding that is left); those of application::plan_extension,
// put_in_force and fit_extension.
Result<AcceptedModel> accept_all(const diagnosis::Diagnosis& found, const Dataset& data,
                                 CellTime time_zero);

// When a target is asked for: with the axes at the row's place already, as a controller that
// corrects on arrival, or before the move, with the axes where the row before has left them. It
// makes a difference to terms that read a motor coordinate (play, creep, heat of a drive).
enum class AskedWhen : std::uint8_t { on_arrival, before_the_move };

// data: as they were measured; every channel but the pose is observed, row by row. Errors: those of
// SnapshotBuilder::create and anchor, and the refusal of a target.
Result<ServedErrors> served_errors(const calibration::Model& model, const CellDescription& cell,
                                   const Dataset& data, const TrueRows& truth,
                                   AskedWhen when = AskedWhen::on_arrival);

// A term of the model reads a motor coordinate.
bool reads_motors(const calibration::Model& model);

// "cyclic_error x + ..."; "" for no finding.
std::string names_of(const diagnosis::Diagnosis& found);

double rms_of(const std::vector<double>& errors);  // mean included

// Worse by more than 5 % and by more than 1 nm, rms at the truth (issue 13).
bool is_harmed(double before_rms_nm, double after_rms_nm);

// Geometric mean of ratios (two or more) and its interval by Student's t on the logarithms.
struct MeanRatio {
  double mean = 1, low = 0, high = 0;
};
MeanRatio mean_ratio(const std::vector<double>& ratios, double confidence);

}  // namespace driftwise::hidden
