#pragma once
// What the simulation gets wrong: the discrepancy of a dataset against a baseline, the causes that
// these data support, what each is worth on rows that took no part, and what is left.
//
// How (NUMERICS.md section 3, docs/diagnosis.md): screen sensors and rows; per output a noise model
// of physical shape; every cause of the catalogue over a grid of its unknown parameter, whitened;
// the best one is named when series simulated from the noise, searched the same way, do as well
// less often than alpha; its parameter is refined; again, with it in the simulation. What stays
// beyond noise and is in no catalogue is said to be there, with what it goes with.
//
// The shape of the result is that of the diagnosis JSON (DESIGN section 4) and of
// diagnosis_service.proto: Diagnosis.outputs has what the JSON spreads over baseline, discrepancy
// and extended, and each row's residual before and after for plots. Finding: finding.h.
//
// Deterministic: the same data and options give the same diagnosis, whatever the executor. No
// clock, no thread of its own.

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/calibration/fit.h"
#include "server/calibration/model/executor.h"
#include "server/core/data/accuracy.h"
#include "server/core/data/dataset.h"
#include "server/core/result.h"
#include "server/diagnosis/answer/finding.h"
#include "server/diagnosis/answer/lever_limits.h"
#include "server/diagnosis/answer/shares.h"

namespace driftwise::diagnosis {

enum class Verdict : std::uint8_t { adequate, extended, unexplained };
std::string_view to_string(Verdict verdict);

struct OutputSummary {
  std::string output, unit;                 // "q1", "nm": of everything here
  double u90 = 0;                           // of the discrepancy, calibration rows
  double mean = 0, a90 = 0;                 // ... figures of server/core/data/accuracy.h
  std::optional<double> noise_floor_u90{};  // from repeated poses, where there are any
  double u90_calibration_before = 0, u90_calibration_after = 0;
  double mean_calibration_before = 0, mean_calibration_after = 0;
  double a90_calibration_before = 0, a90_calibration_after = 0;
  // Rows held out: Diagnosis::judged_on says which.
  std::optional<double> u90_validation_before{}, u90_validation_after{};
  std::optional<double> mean_validation_before{}, mean_validation_after{};
  std::optional<double> a90_validation_before{}, a90_validation_after{};
  double noise_white_sd = 0, noise_slow_sd = 0, noise_tau_s = 0;  // of what is left
  std::vector<Share> explained_by{};  // of the discrepancy, largest first
  std::vector<double> before{},
      after{};  // one per row of the dataset; NaN where a value is missing
};

struct NotTestable {
  std::string cause, why;
};

struct LeftOver {  // structure that no entry of the catalogue explains
  std::string goes_with;
  double p_adjusted = 1;
};

// The measurement that would tell an indistinguishable set apart. diagnose() does not design one:
// whoever does fills it in. Empty trajectory: none within the limits, and why.
struct SeparatingExperiment {
  std::string why;
  std::optional<double> predicted_power;
  std::string trajectory_csv;
  double estimated_s = 0;
};

struct Diagnosis {
  Verdict verdict = Verdict::adequate;
  std::string baseline_formula;
  std::string extended_formula;  // the same where nothing was found
  std::vector<OutputSummary> outputs;
  std::vector<Finding> findings;  // the strongest first
  std::vector<NotTestable> not_testable;
  std::vector<LeftOver> left_over;
  std::optional<SeparatingExperiment> separating_experiment;
  std::vector<std::string> warnings;
  std::size_t rows_calibration = 0, rows_held_out = 0;
  JudgedRows judged_on = JudgedRows::validation;  // or blocks of time, where none are marked
  int nulls = 0;
};

struct DiagnoseOptions {
  calibration::Candidates baseline;  // the simulation as it is now; all of its terms are in
  double alpha = 0.003;              // of a false name where there is none
  int max_findings = 8;
  int nulls = 199;  // series of noise at most; fewer are drawn where the answer is clear
  std::uint64_t seed = 1;
  std::vector<std::string> exclude_symbols;  // channels that no cause may read
  std::optional<LeverLimits> levers;         // of the cell's beams; nothing: any
  // What the simulation gives beside the baseline's terms, such as a robot's kinematics: rows x
  // outputs, each in its channel's unit. Empty: nothing.
  Eigen::MatrixXd simulated;
  calibration::Executor executor;
  // Called here, in the thread of diagnose(), at least every 100 ms: how far it is (0 to 1, never
  // backwards) and what it does. false: cancel.
  std::function<bool(double fraction, const std::string& step)> progress;
  // Name of a row of the dataset, for sentences. None: "row 17" by its place, as in a file.
  std::function<std::string(std::size_t row)> row_name;

  std::string name_of_row(std::size_t row) const {
    return row_name ? row_name(row) : "row " + std::to_string(row + 1);
  }
};

}  // namespace driftwise::diagnosis
