#pragma once
// A formula as written, before it meets a file: what formula_parser makes and formula_expander
// reads.

#include <memory>
#include <string>
#include <vector>

#include "server/effects/term.h"
#include "server/formats/formula/formula.h"

namespace driftwise::formats {

struct FormulaNode {
  enum class Kind {
    name,    // a channel, T, R or F; name
    range,   // t05..t10; name, name_to
    one,     // 1
    power,   // parts[0] ^ number
    poly,    // parts: names; number: degree
    effect,  // name(parts..., quantities)
    cross,   // parts joined by :
    star,    // parts joined by *
    sum,     // parts, each with a sign
  };
  Kind kind = Kind::one;
  std::size_t at = 0;  // where it starts in the text
  std::string name, name_to;
  int number = 0;
  std::vector<FormulaNode> parts;
  std::vector<char> signs;  // of a sum: '+' or '-', one per part
  std::vector<effects::Quantity> quantities;
  bool parenthesised = false;
};

struct FormulaOutput {
  std::string name;
  std::size_t at = 0;
};

// One tree for `~` texts, one for a single term.
struct ParsedFormula {
  std::vector<FormulaOutput> outputs;
  FormulaNode sum;
};

Result<ParsedFormula> parse_formula_text(std::string_view text, const FormulaLimits& limits);
Result<FormulaNode> parse_term_text(std::string_view text, const FormulaLimits& limits);

// Prints a tree so that it parses back to itself.
std::string print_formula(const ParsedFormula& formula);

// A tree's terms against a file's channels. text: what the tree was parsed from, for error
// messages. The constant stands among the terms as Term{}.
Result<std::vector<effects::Term>> expand_sum(
    const FormulaNode& sum, const std::vector<Channel>& channels,
    const std::vector<std::pair<std::string, std::string>>& parts, std::string_view text,
    const FormulaLimits& limits);

// "the file has: x y t01"; long lists are cut.
std::string known_symbols(const std::vector<Channel>& channels);

// "unknown channel 'to7': did you mean t07? the file has: ..."
std::string unknown_symbol(const std::string& symbol, const std::vector<Channel>& channels);

}  // namespace driftwise::formats
