#pragma once
// The formula language of models, after R's:  q ~ poly(x, y, z, 3) + F + F^2 + T + t05..t10 + a:b +
// a*b - term - 1
//
//   sum      := ["-"] product { ("+" | "-") product }     "-" removes terms that stand before it
//   product  := cross { "*" cross }                       a*b = a + b + a:b
//   cross    := power { ":" power }                       every term of the left times every term
//   of the right power    := primary [ "^" whole number ]              of one channel: x^2 primary
//   := channel | T | R | F | t05..t10 | 1 | "(" sum ")" | poly(a, b, ..., degree) | effect(channel,
//   300 s) formula  := output { "+" output } "~" sum             q: every motor coordinate
//
// A symbol is a channel name without its unit. T: every structure temperature of the file; R:
// those on the robot (dataset_parts.h); F: force. An effect over several channels (rate(T, 300 s))
// is one term per channel. Spaces do not matter. poly(): all raw monomials of total
// degree 1..degree, by degree.

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/calibration/fit.h"
#include "server/core/data/dataset.h"
#include "server/core/result.h"
#include "server/effects/term.h"

namespace driftwise::formats {

struct FormulaLimits {
  std::size_t text_bytes = 1 << 20;
  int nesting = 64;
  std::size_t terms = 2000;  // candidates after expansion
  int degree = 20;           // of one power, of poly
};

class Formula {
 public:
  // Errors: invalid_argument BAD_FORMULA: what was found, what was expected, the column, and the
  // text with a caret below it; FORMULA_TOO_LARGE.
  static Result<Formula> parse(std::string_view text, const FormulaLimits& limits = {});

  // "q ~ poly(x, y, z, 3) + F - t03": spaces and signs normalised; parses back to the same formula.
  const std::string& canonical() const;

  // Against a file's channels. Errors, invalid_argument: UNKNOWN_CHANNEL (with caret and the
  // channels there are), BAD_FORMULA (an output among its own terms, nothing to remove),
  // UNKNOWN_EFFECT, BAD_EFFECT, FORMULA_TOO_LARGE.
  // parts: symbol and part of the thermometers, for R.
  Result<calibration::Candidates> expand(
      const std::vector<Channel>& channels,
      const std::vector<std::pair<std::string, std::string>>& parts = {}) const;
  Result<calibration::Candidates> expand(const Dataset& dataset) const;

  Formula(Formula&&) noexcept;
  Formula& operator=(Formula&&) noexcept;
  ~Formula();

 private:
  struct Tree;
  explicit Formula(std::unique_ptr<const Tree> tree);
  std::unique_ptr<const Tree> tree_;
};

// One term as effects::notation prints it: "x^2:t07", "rate(t07, 300 s)", "datum(2)", "1". Errors
// as parse().
Result<effects::Term> parse_term(std::string_view text);
// As a person writes it of these data: a period may be in any unit, as in expand().
Result<effects::Term> parse_term(std::string_view text, const Dataset& dataset);

// Formula::parse, expand and calibration::fit in one: options.candidates is what the formula says.
Result<calibration::Model> fit_formula(const Dataset& dataset, std::string_view formula,
                                       calibration::FitOptions options);

}  // namespace driftwise::formats
