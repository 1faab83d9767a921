#pragma once
// What is done with returns to zero, as [closure] and [[closure_limit]] of cell.toml say it. Kept
// in the text of the cell file: formats::closure_rules_of(). Plain data.

#include <string>
#include <vector>

namespace driftwise {

// What is done with a return to zero that is beyond its limit and not explained.
enum class UnexplainedClosure {
  new_datum,  // the line is suspect, a new datum is opened
  mark,       // the line is suspect, the datum stays
  repeat,     // the line is measured again, at most ClosureRules::repeats times; then new_datum
};

// Of one coordinate, in the unit of a closure: nm of a length, arcsec of a rotation.
struct ClosureLimitDescription {
  std::string channel;  // "x_mm", "rx_arcsec"
  double limit = 0;
};

struct ClosureRules {
  UnexplainedClosure unexplained = UnexplainedClosure::new_datum;
  int repeats = 2;
  std::vector<ClosureLimitDescription> limits;  // others: [plausibility] closure_nm, closure_arcsec
};

}  // namespace driftwise
