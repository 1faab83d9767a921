#pragma once
// Terms as algebra: the canonical form, products, the channels a term needs, and the one special
// term datum(k).

#include <optional>
#include <string>
#include <vector>

#include "server/effects/term.h"

namespace driftwise::effects {

// Powers of one symbol merged, factors ordered: pose, motor coordinates, force, temperatures,
// others; effects after the plain power of their first symbol. Two terms are the same column
// exactly when their canonical forms are equal.
Term canonical(const Term& term);
Term product(const Term& a, const Term& b);

std::string notation(const Factor& factor);
std::string number_text(double value);  // shortest text that reads back exactly

// Every channel symbol the term reads, each once, in the order of its factors.
std::vector<std::string> symbols_of(const Term& term);

// datum(k): the constant of the k-th datum of the data that a model was fitted to, k = 2, 3, ...
// (the model's own constant belongs to its first datum). 1 on rows of that datum, else 0. Always
// in, never tested, never served.
Term datum_term(int ordinal);
std::optional<int> datum_of(const Term& term);  // its k, if the term is datum(k)

}  // namespace driftwise::effects
