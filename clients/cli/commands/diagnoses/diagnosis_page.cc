#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "clients/cli/commands/diagnoses/diagnosis_commands.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/pages/accuracy_line.h"

namespace driftwise::cli {
namespace {

std::string state_of(const v1::Diagnosis& diagnosis) {
  switch (diagnosis.state()) {
    case v1::Diagnosis::STATE_RUNNING:
      return "running";
    case v1::Diagnosis::STATE_DONE:
      return "done";
    case v1::Diagnosis::STATE_CANCELLED:
      return "cancelled";
    case v1::Diagnosis::STATE_FAILED:
      return "failed";
    default:
      return "unknown";
  }
}

std::string verdict_of(const v1::Diagnosis& diagnosis) {
  switch (diagnosis.verdict()) {
    case v1::VERDICT_ADEQUATE:
      return "adequate: nothing beyond noise is supported";
    case v1::VERDICT_EXTENDED:
      return "extended: what was found explains what was left";
    case v1::VERDICT_UNEXPLAINED:
      return "unexplained: structure remains that no cause of the catalogue explains";
    default:
      return "none";
  }
}

std::string or_dash(bool there, double value) { return there ? fixed(value, 1) : "-"; }

void print_outputs(const Console& console, const v1::Diagnosis& diagnosis) {
  for (const auto& one : diagnosis.accuracy())
    console.out << "accuracy (A90), before -> after: " << accuracy_text(one) << '\n';
  Table table({{"output"},
               {"A90 before", Align::right},
               {"after", Align::right},
               {"held out before", Align::right},
               {"after", Align::right},
               {"mean after", Align::right},
               {"goes with"}});
  for (const auto& output : diagnosis.outputs()) {
    std::string shares;
    for (int i = 0; i < std::min(3, output.explained_by_size()); ++i)
      shares += (i == 0 ? "" : ", ") + output.explained_by(i).variable() + " " +
                fixed(100 * output.explained_by(i).marginal_share(), 0) + " %";
    table.add(
        {output.output() + " (" + output.unit() + ")", fixed(output.a90_calibration_before(), 1),
         fixed(output.a90_calibration_after(), 1),
         or_dash(output.has_a90_validation_before(), output.a90_validation_before()),
         or_dash(output.has_a90_validation_after(), output.a90_validation_after()),
         output.has_mean_validation_after() ? signed_fixed(output.mean_validation_after(), 1) : "-",
         shares});
  }
  if (!table.empty()) table.print(console.out, console.paint_out());
}

void print_finding(const Console& console, const v1::Finding& finding) {
  console.out << '\n'
              << console.paint_out().bold(std::to_string(finding.number()) + "  " +
                                          cause_of(finding))
              << "  (applies to the " << finding.applies_to() << ", p "
              << significant(finding.p_adjusted(), 2) << ")\n   " << finding.sentence() << '\n';
  for (const auto& parameter : finding.parameters()) {
    console.out << "   " << parameter.name() << " = " << significant(parameter.value(), 4);
    if (parameter.has_ci90())
      console.out << "  (90 %: " << significant(parameter.ci90().low(), 4) << " to "
                  << significant(parameter.ci90().high(), 4) << ")";
    console.out << '\n';
  }
  if (finding.indistinguishable_from().empty()) return;
  console.out << "   cannot be told apart from: ";
  for (int i = 0; i < finding.indistinguishable_from_size(); ++i)
    console.out << (i == 0 ? "" : "; ") << finding.indistinguishable_from(i);
  console.out << '\n';
}

void print_extension(const Console& console, const v1::Extension& extension) {
  console.out << "\naccepted by " << extension.accepted_by() << " at "
              << utc_text(extension.accept_time()) << ": findings";
  for (const int number : extension.finding_numbers()) console.out << ' ' << number;
  if (extension.has_model_id())
    console.out << ", model " << extension.model_id()
                << (extension.promoted() ? " (promoted)" : "");
  if (extension.has_correction_id()) console.out << ", correction " << extension.correction_id();
  for (const auto& rows : extension.excluded())
    console.out << ", rows " << rows.first_row() << "-" << rows.last_row() << " of run "
                << rows.run_id() << " kept out";
  if (extension.has_undo_time()) console.out << "\nundone at " << utc_text(extension.undo_time());
  console.out << '\n';
}

}  // namespace

std::string cause_of(const v1::Finding& finding) {
  return finding.cause() + (finding.subject().empty() ? "" : " " + finding.subject());
}

void print_diagnosis(const Console& console, const v1::Diagnosis& diagnosis) {
  const Paint paint = console.paint_out();
  console.out << "diagnosis " << diagnosis.id() << ": " << state_of(diagnosis);
  if (!diagnosis.reason().empty()) console.out << ": " << diagnosis.reason();
  if (!diagnosis.robot().empty()) console.out << "\nrobot     " << diagnosis.robot();
  console.out << "\nbaseline  " << diagnosis.baseline_formula();
  if (diagnosis.has_model_id()) console.out << "  (model " << diagnosis.model_id() << ")";
  console.out << '\n';
  if (diagnosis.state() != v1::Diagnosis::STATE_DONE) return;
  console.out << "verdict   " << paint.bold(verdict_of(diagnosis)) << "\n\n";
  print_outputs(console, diagnosis);
  for (const auto& finding : diagnosis.findings()) print_finding(console, finding);
  for (const auto& rest : diagnosis.left_over())
    console.out << "\nleft over: goes with " << rest.goes_with() << " (p "
                << significant(rest.p_adjusted(), 2) << ")\n";
  if (diagnosis.has_separating_experiment()) {
    const auto& experiment = diagnosis.separating_experiment();
    console.out << "\nseparating measurement: " << experiment.why();
    if (experiment.has_predicted_power())
      console.out << " (power " << fixed(experiment.predicted_power(), 2) << ")";
    console.out << '\n';
  }
  for (const auto& warning : diagnosis.warnings())
    console.out << paint.warn("warning: ") << warning << '\n';
  if (!diagnosis.not_testable().empty()) {
    // Each cause once, also of a diagnosis that was stored with one line per axis.
    std::vector<std::string> causes;
    for (const auto& one : diagnosis.not_testable())
      if (std::ranges::find(causes, one.cause()) == causes.end()) causes.push_back(one.cause());
    std::string list;
    for (const auto& cause : causes) list += (list.empty() ? " " : "; ") + cause;
    console.out << "\nnot testable with these data:" << list << '\n';
  }
  if (diagnosis.has_extension()) print_extension(console, diagnosis.extension());
}

}  // namespace driftwise::cli
