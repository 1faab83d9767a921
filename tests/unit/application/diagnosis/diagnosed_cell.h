#pragma once
// A cell in memory whose search for causes is scripted: what is tested is what the daemon makes of
// a diagnosis, not the diagnosis.

#include <boost/asio/io_context.hpp>

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
