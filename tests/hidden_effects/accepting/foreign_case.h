#pragma once
// One data set of the independent population: diagnosed as the command line does, its findings
// accepted as the daemon does, and the served target judged at the generator's noise-free truth.

#include <string>
#include <vector>

#include "tests/hidden_effects/accepting/foreign_orders.h"

namespace driftwise::hidden {

// Errors of one motor coordinate over the judged rows, rms with the mean included.
struct OutputErrors {
  std::string output;  // "q1"
  double before_nm = 0, after_nm = 0;
  double mean_before_nm = 0, mean_after_nm = 0;
  double inside_before_nm = 0, inside_after_nm = 0;  // rows within the fitted domain of the pose
};

struct ForeignCase {
  int number = 0;
  foreign::Order order;
  std::string robot, plan, noise;
  std::vector<std::string> hidden;  // "thermal_lag t02"
  int axes = 0;
  // validation: the rows that the plan holds out. withheld: five blocks of a twenty-fifth of the
  // rows, evenly spread, the last at the end, marked as kept out of fits before the diagnosis.
  std::string judged_on;
  int rows = 0, rows_judged = 0, rows_inside = 0;

  std::string verdict, named;
  bool named_right = false;   // the findings' causes are the hidden ones
  bool one_of_a_set = false;  // a finding stands for an indistinguishable set
  // not_generated, not_diagnosed, nothing_found, not_served (the baseline cannot be served),
  // refused (nothing of it can be accepted and served), accepted.
  std::string outcome;
  std::string reason, message;   // of the error, where there is one
  std::string formula, changed;  // of the accepted model; what the correction stage and rows take
  std::vector<OutputErrors> outputs;
  // In no catalogue: the same with the effect as the instruments' error. outputs has it as the
  // robot's.
  std::vector<OutputErrors> outputs_as_instrument;
  // A model that reads motor coordinates: the same with targets asked for before each move. outputs
  // has them asked for on arrival.
  std::vector<OutputErrors> outputs_before_move;
  double cpu_s = 0;

  bool is_accepted() const { return outcome == "accepted"; }
};

// Deterministic. nulls: of the diagnosis, 199 as the command line has.
ForeignCase judged_case(const NumberedOrder& ordered, int nulls);

// All outputs together, after over before.
double ratio_of(const std::vector<OutputErrors>& outputs, bool inside_only = false);
// Any output is harmed (is_harmed).
bool has_harm(const std::vector<OutputErrors>& outputs, bool inside_only = false);

// One line of JSON, and back. Throws std::runtime_error for a line that is none.
std::string json_line(const ForeignCase& one);
ForeignCase case_of_line(const std::string& line);

}  // namespace driftwise::hidden
