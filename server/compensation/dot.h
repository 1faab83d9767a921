#pragma once
// The inner loops of a target. Two numbers in a register, written out: a development build, which
// inlines no lambda, runs them nearly as fast as a release.

#include <cstddef>

namespace driftwise::compensation {

typedef double Pair __attribute__((vector_size(16)));
// Named wherever it is used: `auto` drops the attributes of a type, and with them the alignment.
typedef double LoosePair __attribute__((vector_size(16), aligned(8), may_alias));

// sum of a[i] * b[i]. Eight partial sums, two in a register: one sum alone would wait for its own
// last addition, four cycles a term.
inline double dot(const double* a, const double* b, std::size_t count) {
  Pair s0{}, s1{}, s2{}, s3{};
  std::size_t i = 0;
  for (; i + 8 <= count; i += 8) {
    const LoosePair* p = reinterpret_cast<const LoosePair*>(a + i);
    const LoosePair* q = reinterpret_cast<const LoosePair*>(b + i);
    s0 += p[0] * q[0];
    s1 += p[1] * q[1];
    s2 += p[2] * q[2];
    s3 += p[3] * q[3];
  }
  const Pair pairs = (s0 + s1) + (s2 + s3);
  double sum = pairs[0] + pairs[1];
  for (; i < count; ++i) sum += a[i] * b[i];
  return sum;
}

// to[i] = factor * values[i].
inline void scale(double factor, const double* values, double* to, std::size_t count) {
  const Pair both = {factor, factor};
  std::size_t i = 0;
  for (; i + 2 <= count; i += 2)
    *reinterpret_cast<LoosePair*>(to + i) = both * *reinterpret_cast<const LoosePair*>(values + i);
  for (; i < count; ++i) to[i] = factor * values[i];
}

}  // namespace driftwise::compensation
