// What a diagnosis said against what the plant hid.

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "drivers/all_devices.h"
#include "server/calibration/design/predict.h"
#include "server/calibration/fit.h"
#include "server/core/units.h"
#include "server/diagnosis/diagnose.h"
#include "server/formats/cell_file/cell_file.h"
#include "server/formats/formula/formula.h"
#include "tests/hidden_effects/plants/plant_cases.h"

namespace driftwise::hidden {
namespace {

std::string name_of_one(const diagnosis::Finding& finding) {
  return finding.cause + (finding.subject.empty() ? "" : " " + finding.subject);
}

bool right_place(const PlantCase& one, const std::string& cause, const std::string& subject,
                 const std::string& where) {
  if (cause != one.cause) return false;
  if (!one.where.empty() && !where.empty() && where != one.where) return false;
  return one.subjects.empty() || std::ranges::find(one.subjects, subject) != one.subjects.end();
}

std::optional<calibration::Model> plain_fit(const Dataset& data, const std::string& formula) {
  calibration::FitOptions options;
  options.candidates = *formats::Formula::parse(formula)->expand(data);
  options.select = calibration::Select::all;
  options.blocks = 0;
  auto model = calibration::fit(data, options);
  if (!model) return std::nullopt;
  return std::move(*model);
}

// S90 over the validation rows of the output that is worst, by plain least squares of these terms.
std::vector<double> validation_u90_nm(const Dataset& data, const std::string& formula) {
  const auto model = plain_fit(data, formula);
  std::vector<double> u90;
  if (!model) return u90;
  for (const auto& output : model->outputs)
    u90.push_back(output.accuracy.u90_validation.value_or(NAN) * 1e6);
  return u90;
}

// Measured minus predicted at the calibration rows, nm, of one output.
std::vector<double> left_by(const calibration::OutputModel& output, const Dataset& data) {
  const auto predicted = *calibration::predict(data, output);
  const auto measured = data.values_of(output.channel.symbol);
  std::vector<double> left;
  for (std::size_t row = 0; row < data.rows; ++row)
    if (data.set_of(row) == PointSet::calibration)
      left.push_back((measured[row] - predicted[static_cast<Eigen::Index>(row)]) * kNmPerMm);
  return left;
}

}  // namespace

std::optional<double> left_to_find_nm(const PlantCase& one, const PlantRun& run,
                                      std::uint64_t seed) {
  if (one.overrides.empty()) return std::nullopt;
  auto clean = one;
  clean.overrides.clear();
  const auto without = run_case(clean, seed);
  if (run.data.time_s != without.data.time_s) return std::nullopt;
  const auto here = plain_fit(run.data, one.baseline);
  const auto there = plain_fit(without.data, one.baseline);
  if (!here || !there) return std::nullopt;
  double largest = 0;
  for (std::size_t o = 0; o < here->outputs.size(); ++o) {
    const auto a = left_by(here->outputs[o], run.data);
    const auto b = left_by(there->outputs[o], without.data);
    double square = 0;
    for (std::size_t i = 0; i < a.size(); ++i) square += (a[i] - b[i]) * (a[i] - b[i]);
    largest = std::max(largest, std::sqrt(square / static_cast<double>(a.size())));
  }
  return largest;
}

CellDescription cell_of(const PlantCase& one) {
  const std::string folder = one.micro_nano ? "micro-nano" : "linear-axis";
  auto cell = formats::read_cell_file(
      std::string(DRIFTWISE_SOURCE_DIR) + "/deploy/cells/" + folder + "/cell.toml",
      drivers::all_devices());
  if (!cell) throw std::runtime_error(cell.error().message);
  return std::move(*cell);
}

diagnosis::Diagnosis diagnosed_case(const PlantCase& one, const Dataset& data, int nulls) {
  return diagnosed_run(one.baseline, data, nulls, diagnosis::declared_lever_limits(cell_of(one)));
}

diagnosis::Diagnosis diagnosed_run(const std::string& baseline, const Dataset& data, int nulls,
                                   const std::optional<diagnosis::LeverLimits>& levers) {
  diagnosis::DiagnoseOptions options;
  const auto formula = formats::Formula::parse(baseline);
  if (!formula) throw std::runtime_error(formula.error().message);
  auto candidates = formula->expand(data);
  if (!candidates) throw std::runtime_error(candidates.error().message);
  options.baseline = std::move(*candidates);
  options.nulls = nulls;
  options.levers = levers;
  auto found = diagnosis::diagnose(data, options);
  if (!found) throw std::runtime_error(found.error().message);
  return std::move(*found);
}

PlantVerdict judged_by_truth(const PlantCase& one, const PlantRun& run,
                             const diagnosis::Diagnosis& diagnosis) {
  PlantVerdict verdict;
  int named = 0;
  bool listed = false, other = false, beside = false;
  for (const auto& finding : diagnosis.findings) {
    verdict.named += (verdict.named.empty() ? "" : " + ") + name_of_one(finding);
    for (const auto& rival : finding.indistinguishable_from) verdict.named += " ~ " + rival;
    const bool right = right_place(one, finding.cause, finding.subject, finding.where);
    bool mentions = false;
    for (const auto& rival : finding.indistinguishable_from) {
      const auto space = std::min(rival.find(' '), rival.size());
      const std::string subject = space < rival.size() ? rival.substr(space + 1) : "";
      mentions |= right_place(one, rival.substr(0, space), subject, "");
    }
    const bool comes_with = std::ranges::find(one.also, finding.cause) != one.also.end();
    named += right ? 1 : 0;
    listed |= mentions;
    beside |= !right && !comes_with;
    other |= !right && !mentions && !comes_with;
  }
  if (diagnosis.verdict == diagnosis::Verdict::unexplained)
    verdict.named += " (unexplained: " + diagnosis.left_over.front().goes_with + ")";
  const bool nothing_more = !other && diagnosis.verdict != diagnosis::Verdict::unexplained;
  if (one.cause.empty()) {
    verdict.exact = verdict.in_set = diagnosis.findings.empty();
  } else if (one.cause == "unexplained") {
    verdict.exact = verdict.in_set = diagnosis.verdict == diagnosis::Verdict::unexplained && !other;
  } else {
    verdict.exact = named == 1 && nothing_more && !beside;
    verdict.in_set = (named > 0 || listed) && !other;
  }
  verdict.wrong = other;

  // The output that what was hidden shows in most.
  double largest = -1;
  Dataset known = run.data;
  std::string with_truth = one.baseline;
  for (std::size_t k = 0; k < run.hidden_nm.size(); ++k) {
    const std::string symbol = "truth" + std::to_string(k + 1);
    known.columns.push_back({{symbol, "nm"}, run.hidden_nm[k]});
    with_truth += " + " + symbol;
  }
  const auto oracle =
      run.hidden_nm.empty() ? std::vector<double>() : validation_u90_nm(known, with_truth);
  for (std::size_t o = 0; o < diagnosis.outputs.size(); ++o) {
    const auto& output = diagnosis.outputs[o];
    if (!output.u90_validation_before || !output.u90_validation_after) continue;
    const double reach = o < oracle.size() ? oracle[o] : *output.u90_validation_after;
    const double gain = *output.u90_validation_before - reach;
    if (gain <= largest) continue;
    largest = gain;
    verdict.u90_before = *output.u90_validation_before;
    verdict.u90_after = *output.u90_validation_after;
    verdict.u90_known = o < oracle.size() ? oracle[o] : NAN;
  }
  return verdict;
}

}  // namespace driftwise::hidden
