#pragma once
// The inner loop of a target.

#include <cstddef>

namespace driftwise::compensation {

// sum of a[i] * b[i]. Eight partial sums, two in a register: one sum alone would wait for its own
// last addition, four cycles a term.
inline double dot(const double* a, const double* b, std::size_t count) {
  typedef double Pair __attribute__((vector_size(16)));
  typedef double LoosePair __attribute__((vector_size(16), aligned(8), may_alias));
  const auto pair = [](const double* at) -> Pair {
    return *reinterpret_cast<const LoosePair*>(at);
  };
  Pair s0{}, s1{}, s2{}, s3{};
  std::size_t i = 0;
  for (; i + 8 <= count; i += 8) {
    s0 += pair(a + i) * pair(b + i);
    s1 += pair(a + i + 2) * pair(b + i + 2);
    s2 += pair(a + i + 4) * pair(b + i + 4);
    s3 += pair(a + i + 6) * pair(b + i + 6);
  }
  const Pair pairs = (s0 + s1) + (s2 + s3);
  double sum = pairs[0] + pairs[1];
  for (; i < count; ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace driftwise::compensation
