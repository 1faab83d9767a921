#pragma once
// From findings to what is made of them (DESIGN: where an effect applies). Pure.
//
// robot       the findings' terms join the baseline's formula: a new model, fitted from the same
//             runs (extension_fit.h);
// correction  what the length read too much, from the motor side through the simulation's slopes
//             (server/simulation/motor_slopes.h): laid over the data of every run, earlier and
//             later ones, before anybody fits them, and never part of a model. A finding about one
//             axis is that axis' alone; terms that read the data's clock hold for these runs only;
// dataset     wrong rows are kept out, a jump splits its datum, a sensor that lies is left out of
//             these runs. A change of noise changes nothing by itself.
//
// A target follows the robot and no instrument. A finding that may be either's
// (server/application/diagnoses/whose.h) is made only as what the caller says it is.

#include <string>
#include <vector>

#include "server/application/datasets/amended_dataset.h"
#include "server/diagnosis/answer/diagnosis.h"

namespace driftwise::application {

struct ExtensionPlan {
  std::vector<int> findings;                 // numbers from 1, ascending
  std::string baseline;                      // formula that is fitted
  std::string formula;                       // of the model that it makes
  bool extends_model = false;                // the formula has terms that the baseline has not
  std::vector<diagnosis::Finding> of_robot;  // whose terms the target follows
  correction::DataAmendment amendment;
  std::vector<ExclusionRecord> exclusions;  // one per run; without who and when
};

// wanted: numbers from 1; empty: all but corrections that are not known well enough
// (diagnosis::correction_is_uncertain). Errors: failed_precondition NOTHING_FOUND,
// INDISTINGUISHABLE (all are wanted, and one of them stands for a set); not_found NO_SUCH_FINDING.
Result<std::vector<int>> chosen_findings(const diagnosis::Diagnosis& found,
                                         std::vector<int> wanted);

// data: of the diagnosis' runs, as it saw them. taken_as: what the one chosen finding is that may
// be the robot's or an instrument's: "robot", "instrument", a cause of its set, or kAsNamed; "":
// not said. Errors: failed_precondition NOTHING_TO_MAKE (only findings that change nothing),
// UNCERTAIN_CORRECTION (a finding that is chosen), INDISTINGUISHABLE (a chosen finding may be
// either's, and taken_as is empty), NO_SUCH_FINDING (taken_as is no cause of it, or none of the
// chosen is open), NO_LENGTH (an instrument's error that no length of these data can take); those
// of check_instrument (instrument_agreement.h), formats::fit_formula, motor_slopes and
// diagnosis::open_hypotheses.
Result<ExtensionPlan> plan_extension(DiagnosisId id, const diagnosis::Diagnosis& found,
                                     const std::vector<int>& chosen, const RunsData& data,
                                     const std::string& taken_as = "");

// Runs that what is made of a finding acts on, in the order of their number. `marks`: rows kept out
// and sensors left out, in the runs of the diagnosis. `own_runs`: a jump, and a correction that
// reads the data's clock; it changes what those runs say. Fresh runs can show no gain of either.
enum class Reach { marks, own_runs, every_run };
Reach reach_of(const diagnosis::Finding& finding);

// Of the numbered findings those that plan_extension would not refuse as INDISTINGUISHABLE.
std::vector<int> with_known_side(const diagnosis::Diagnosis& found, std::vector<int> numbers,
                                 const RunsData& data);

// The data as they are once the plan is in force. Errors: those of correction::amend.
Result<void> put_in_force(const ExtensionPlan& plan, RunsData& data);

}  // namespace driftwise::application
