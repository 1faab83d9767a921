#pragma once
// Tokens of the formula language, each with the column it starts in.

#include <string>
#include <string_view>
#include <vector>

#include "server/core/reasons.h"
#include "server/core/result.h"

namespace driftwise::formats {

enum class FormulaToken {
  name,
  number,
  tilde,
  plus,
  minus,
  star,
  colon,
  power,
  open,
  close,
  comma,
  range,
  end
};

struct FormulaLexeme {
  FormulaToken token = FormulaToken::end;
  std::string text;
  double number = 0;
  std::size_t at = 0;  // byte offset
};

// Errors: BAD_FORMULA at the first character that starts no token.
Result<std::vector<FormulaLexeme>> lex_formula(std::string_view text);

// "<what>, column 7:\n  q ~ x + ?\n          ^": long texts are cut to a window around the place.
std::string point_at(std::string_view text, std::size_t at, const std::string& what);
tl::unexpected<Error> bad_formula(std::string_view text, std::size_t at, const std::string& what,
                                  std::string reason = reasons::kBadFormula);

}  // namespace driftwise::formats
