#pragma once
// The accuracy figures of a set of errors: the only place that computes them.
//
// mean: sum(e) / n.
// S90: 1.645 x standard deviation about the mean (n - 1), the study's U90; always with its mean.
// A90: 1.645 x root mean square, sqrt(sum(e^2) / n), mean included. The accuracy that heads a page,
// a verdict, a list, a promotion and a comparison.
// A percentile of the rows themselves would be too noisy: of 40 rows it rests on four.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace driftwise {

struct ErrorFigures {  // in the unit of the errors
  std::int64_t rows = 0;
  double mean = 0, u90 = 0, a90 = 0;
  bool operator==(const ErrorFigures&) const = default;
};

// Sums over rows, which can be added: of one fold, of one block.
struct ErrorSums {
  double rows = 0, sum = 0, squares = 0;
  void add(double error) { rows += 1, sum += error, squares += error * error; }
  ErrorSums& operator+=(const ErrorSums& other);
  ErrorSums operator-(const ErrorSums& other) const;
};

// S90 is 0 of fewer than two rows, all figures 0 of none.
ErrorFigures error_figures(const ErrorSums& sums);
// Rows without a finite value are left out. About their mean first: no loss of digits.
ErrorFigures error_figures(std::span<const double> errors);

// Which rows an accuracy was judged on.
enum class JudgedRows : std::uint8_t {
  validation,   // rows marked validation
  blocks,       // contiguous blocks of time, each predicted without itself
  calibration,  // none was held out: the rows of the fit itself
  fresh         // measured after the model was made
};
// "validation", "blocks", "calibration", "fresh": for programs.
std::string_view to_string(JudgedRows rows);
std::optional<JudgedRows> judged_rows_from(std::string_view text);
// "validation rows", "held-out blocks of time", "the fit's own rows, none held out": for people.
std::string_view in_words(JudgedRows rows);

// One judged figure of one output, and what it was before a change on the same output and rows.
struct JudgedAccuracy {
  std::string output, unit;  // "q1", "nm"
  JudgedRows rows = JudgedRows::validation;
  ErrorFigures figures;
  std::optional<ErrorFigures> before{};
};

// The accuracy that heads a page: per unit, in the order of their first output, the largest A90
// among the outputs of that unit and their held-out rows. The fit's own rows count only for a unit
// of which nothing was held out.
std::vector<JudgedAccuracy> heading_of(std::span<const JudgedAccuracy> judged);

// "42.3 nm (q1, validation rows, mean +24.3 nm, S90 12.8 nm)"; with before "53 -> 42.3 nm (q1...".
std::string accuracy_text(const JudgedAccuracy& accuracy);

}  // namespace driftwise
