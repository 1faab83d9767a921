#pragma once
// A term of a model as a value: a product of factors, each a channel's power or an effect's output.
// "x^2", "x:t07", "rate(t07, 300 s)". The notation can be printed and typed back
// (server/formats/formula).

#include <string>
#include <variant>
#include <vector>

namespace driftwise::effects {

struct Power {  // x^2
  std::string symbol;
  int exponent = 1;
  bool operator==(const Power&) const = default;
};

struct Quantity {  // 300 s
  double value = 0;
  std::string unit;  // "s", "nm", "" for a plain number
  bool operator==(const Quantity&) const = default;
};

struct Call {  // rate(t07, 300 s): an effect of the catalogue with its memory
  std::string effect;
  std::vector<std::string> symbols;  // the channels it observes, in the notation's order
  std::vector<Quantity> parameters;
  bool operator==(const Call&) const = default;
};

using Factor = std::variant<Power, Call>;

struct Term {
  std::vector<Factor> factors;  // empty: the constant
  bool is_constant() const { return factors.empty(); }
  bool operator==(const Term&) const = default;
};

// Canonical: factors in the order symbols appear in pose, force, temperatures, others; powers
// merged.
std::string notation(const Term& term);  // the constant is "1"

}  // namespace driftwise::effects
