#pragma once
// A cell in memory whose search for causes is scripted: what is tested is what the daemon makes of
// a diagnosis, not the diagnosis.

#include <boost/asio/io_context.hpp>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "server/formats/formula/formula.h"
#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {

namespace dx = driftwise::diagnosis;

// A finding about q1 whose terms have these coefficients in q1_mm.
inline dx::Finding finding_of(const std::string& cause, const std::string& subject,
                              effects::AppliesTo applies_to, const std::vector<std::string>& terms,
                              std::vector<double> coefficients) {
  dx::Finding finding;
  finding.cause = cause;
  finding.subject = subject;
  finding.applies_to = applies_to;
  for (const auto& term : terms) finding.terms.push_back(*formats::parse_term(term));
  dx::FindingOutput q1;
  q1.output = "q1";
  q1.unit = "nm";
  q1.shown = true;
  q1.coefficients = std::move(coefficients);
  finding.outputs = {q1};
  finding.sentence = cause + " " + subject;
  return finding;
}

inline dx::Diagnosis diagnosis_with(const std::string& baseline,
                                    std::vector<dx::Finding> findings) {
  dx::Diagnosis d;
  d.baseline_formula = d.extended_formula = baseline;
  d.verdict = findings.empty() ? dx::Verdict::adequate : dx::Verdict::extended;
  d.findings = std::move(findings);
  return d;
}

inline constexpr double kPeriodNm = 93'000;  // long enough for the plan below to see it
inline constexpr double kCycleNm = 40;

// An imported campaign of an axis with q = 1.0002 x_true, whose interferometer reads a cycle too
// much and whose row 7 is wrong.
inline std::string imported_csv(unsigned seed = 7) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise_nm(0, 2);
  std::string csv = "time_s,set,q1_mm,x_mm,t01_degC\n";
  for (int row = 0; row < 240; ++row) {
    const double x_true_mm = row == 0 ? 0 : -4 + 8.0 * ((row * 89) % 240) / 240.0;
    const double cycle_mm =
        kCycleNm * 1e-6 * std::sin(2 * std::numbers::pi * x_true_mm * 1e6 / kPeriodNm);
    const double wrong_mm = row == 7 ? 5e-3 : 0;
    char line[200];
    std::snprintf(line, sizeof line, "%d,%s,%.9f,%.9f,%.6f\n", 20 * row,
                  row % 4 == 3 ? "validation" : "calibration",
                  1.0002 * x_true_mm + wrong_mm + 1e-6 * noise_nm(random), x_true_mm + cycle_mm,
                  20.5 + 0.001 * row);
    csv += line;
  }
  return csv;
}

class DiagnosedCell {
 public:
  explicit DiagnosedCell(application::Diagnose script, bool on_a_thread_of_its_own = false)
      : cell(world, small_cell(folder / "cell.sqlite"), kSqlite,
             {.begin = kWorldBegin,
              .diagnose = std::move(script),
              .diagnosis_thread =
                  on_a_thread_of_its_own ? elsewhere.get_executor() : asio::any_io_executor()}) {}
  ~DiagnosedCell() { let_diagnoses_run(); }

  // The other thread's turn: what waits for it runs here.
  void let_diagnoses_run() {
    elsewhere.restart();
    elsewhere.poll();
  }
  RunId measured(const std::string& csv) {
    const auto run = cell.begin_run(csv);
    cell.finish_run();
    return run.id;
  }
  application::DiagnosisView begin_diagnosis(RunId run, const std::string& baseline) {
    application::DiagnosisRequest request;
    request.runs = {run};
    request.baseline = baseline;
    const auto view = cell.await(cell->diagnoses.create(cell.ada, std::move(request)));
    if (!view) throw std::runtime_error(view.error().message);
    return *view;
  }
  application::DiagnosisView look(DiagnosisId id) {
    const auto view = cell.await(cell->diagnoses.get(id));
    if (!view) throw std::runtime_error(view.error().message);
    return *view;
  }
  application::DiagnosisView diagnosed(RunId run, const std::string& baseline) {
    const auto id = begin_diagnosis(run, baseline).record.id;
    cell.until([&] { return look(id).record.state != JobState::running; });
    return look(id);
  }

  Folder folder;
  SmallWorld world;
  asio::io_context elsewhere;
  CellInMemory cell;
};

}  // namespace driftwise::tests
