#pragma once
// Which products of fast variables a model needs, and how to make each from a shorter one with one
// multiplication.

#include <array>
#include <cstddef>
#include <map>
#include <vector>

#include "server/compensation/snapshot.h"

namespace driftwise::compensation {

using Exponents = std::array<int, kVariables>;  // by Variable: x^2 y is {2, 1, 0, ...}

class BasisPlan {
 public:
  // The entry of the basis that holds this product; added with what it is made of when it is new.
  // {} is entry 0, the 1.
  std::size_t index_of(const Exponents& exponents);

  std::size_t size() const { return products_.size() + 1; }
  const std::vector<Snapshot::Product>& products() const { return products_; }
  std::uint32_t needed() const { return needed_; }  // bit per Variable

  // All entries at these values (in the columns' units), out: size() numbers.
  void evaluate(const std::array<double, kVariables>& values, std::vector<double>& out) const;

 private:
  std::map<Exponents, std::size_t> known_;
  std::vector<Snapshot::Product> products_;
  std::uint32_t needed_ = 0;
};

}  // namespace driftwise::compensation
