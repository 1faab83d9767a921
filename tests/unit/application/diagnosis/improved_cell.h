#pragma once
// An axis that bends, a search that looks for it, and the loop that improves.

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "tests/unit/application/diagnosis/diagnosed_cell.h"

namespace driftwise::tests {

inline const std::string kLines = lines_of(8, {-4, -2.5, -1, 1.5, 3, 4}, true);

// Knows one cause: x^2. Names it while the baseline lacks it, with what it leaves on these rows.
inline Result<dx::Diagnosis> looks_for_a_bend(const Dataset& data,
                                              const dx::DiagnoseOptions& options) {
  const auto& terms = options.baseline.terms;
  const auto bend = *formats::parse_term("x^2");
  const bool known = std::ranges::find(terms, bend) != terms.end();
  auto d = diagnosis_with(options.baseline.formula, {});
  dx::OutputSummary q1;
  q1.output = "q1";
  q1.unit = "nm";
  const auto& q = data.find("q1")->values;
  const auto& x = data.find("x")->values;
  double sum = 0, square = 0;
  for (std::size_t row = 0; row < data.rows; ++row) {
    sum += q[row] - x[row];
    square += (q[row] - x[row]) * (q[row] - x[row]);
  }
  const auto n = static_cast<double>(data.rows);
  q1.u90_calibration_before = 1.645e6 * std::sqrt(square / n - sum * sum / n / n);
  q1.u90_calibration_after = known ? q1.u90_calibration_before : 20;
  q1.a90_calibration_before = q1.u90_calibration_before;
  q1.a90_calibration_after = q1.u90_calibration_after;
  d.outputs = {q1};
  if (known) return d;
  d.verdict = dx::Verdict::extended;
  d.findings = {finding_of("geometry_order", "x", effects::AppliesTo::robot, {"x^2"}, {-1e-4})};
  return d;
}

// The diagnosis with a gain of q1 that it promises: 300 nm to 20.
inline dx::Diagnosis promising(dx::Diagnosis found) {
  dx::OutputSummary q1;
  q1.output = "q1";
  q1.unit = "nm";
  q1.u90_calibration_before = q1.a90_calibration_before = 300;
  q1.u90_calibration_after = q1.a90_calibration_after = 20;
  found.outputs = {q1};
  return found;
}

class ImprovementTest : public testing::Test {
 protected:
  explicit ImprovementTest(application::Diagnose script = looks_for_a_bend,
                           bool on_a_thread_of_its_own = false)
      : d(std::move(script), on_a_thread_of_its_own) {
    d.world.bend_nm_per_mm2 = 30;
    d.world.warming_k_per_h = 0.01;
  }
  Result<ImprovementRecord> begin(application::ImproveRequest request = {}) {
    if (request.trajectory_text.empty()) request.trajectory_text = kLines;
    request.trajectory_name = "lines.csv";
    if (request.formula.empty()) request.formula = "q ~ x";
    request.lease_token = d.cell.lease();
    return d.cell.await(d.cell->improvements.create(d.cell.ada, std::move(request)));
  }
  ImprovementRecord look(ImprovementId id) {
    return *d.cell.await(
        d.cell.read([id](Store& store) { return store.improvements().improvement(id); }));
  }
  ImprovementRecord finished(ImprovementId id) {
    d.cell.until([&] { return look(id).state != JobState::running; }, 400'000);
    return look(id);
  }

  DiagnosedCell d;
};

}  // namespace driftwise::tests
