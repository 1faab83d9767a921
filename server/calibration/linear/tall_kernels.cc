#include "server/calibration/linear/tall_kernels.h"

#if defined(__clang__)
#define DRIFTWISE_UNROLLED _Pragma("clang loop unroll(full)")
#else
#define DRIFTWISE_UNROLLED _Pragma("GCC unroll 16")
#endif

namespace driftwise::calibration::tall {
namespace {

// Vectors of the compiler's own, so that one text serves every instruction set. loose: as found in
// a block, aligned like a double.
template <int lanes>
struct Lanes;
#define DRIFTWISE_LANES(count)                                                           \
  template <>                                                                            \
  struct Lanes<count> {                                                                  \
    static constexpr Index kCount = count;                                               \
    typedef double Vector __attribute__((vector_size(8 * count)));                       \
    typedef double Loose __attribute__((vector_size(8 * count), aligned(8), may_alias)); \
  };
DRIFTWISE_LANES(2)
DRIFTWISE_LANES(4)
DRIFTWISE_LANES(8)
#undef DRIFTWISE_LANES

// c(i, j) += or = a_i . b_j for I x J columns.
template <class L, int I, int J, bool add>
[[gnu::always_inline]] inline void dot_tile(const double* a, Index a_stride, const double* b,
                                            Index b_stride, Index rows, double* c, Index c_stride) {
  using Vector = typename L::Vector;
  using Loose = const typename L::Loose;
  Vector sums[I][J];
  DRIFTWISE_UNROLLED
  for (int i = 0; i < I; ++i) {
    DRIFTWISE_UNROLLED
    for (int j = 0; j < J; ++j) sums[i][j] = Vector{};
  }
  for (Index row = 0; row < rows; row += L::kCount) {
    Vector left[I];
    DRIFTWISE_UNROLLED
    for (int i = 0; i < I; ++i) left[i] = *reinterpret_cast<Loose*>(a + i * a_stride + row);
    DRIFTWISE_UNROLLED
    for (int j = 0; j < J; ++j) {
      const Vector right = *reinterpret_cast<Loose*>(b + j * b_stride + row);
      DRIFTWISE_UNROLLED
      for (int i = 0; i < I; ++i) sums[i][j] += left[i] * right;
    }
  }
  DRIFTWISE_UNROLLED
  for (int i = 0; i < I; ++i) {
    DRIFTWISE_UNROLLED
    for (int j = 0; j < J; ++j) {
      double sum = 0;
      DRIFTWISE_UNROLLED
      for (Index lane = 0; lane < L::kCount; ++lane) sum += sums[i][j][lane];
      double& place = c[j * c_stride + i];
      place = add ? place + sum : sum;
    }
  }
}

template <class L, int J, bool add>
[[gnu::always_inline]] inline void dot_columns(const Block& a, Index from, const double* b,
                                               Index b_stride, double* c, Index c_stride) {
  Index i = from;
  for (; i + 4 <= a.columns; i += 4)
    dot_tile<L, 4, J, add>(a.data + i * a.stride, a.stride, b, b_stride, a.rows, c + i, c_stride);
  for (; i < a.columns; ++i)
    dot_tile<L, 1, J, add>(a.data + i * a.stride, a.stride, b, b_stride, a.rows, c + i, c_stride);
}

template <class L>
[[gnu::always_inline]] inline void add_gram_on(const Block& x, double* gram) {
  const Index width = x.columns;
  Index j = 0;
  for (; j + 4 <= width; j += 4)
    dot_columns<L, 4, true>(x, j, x.data + j * x.stride, x.stride, gram + j * width, width);
  for (; j < width; ++j)
    dot_columns<L, 1, true>(x, j, x.data + j * x.stride, x.stride, gram + j * width, width);
}

template <class L>
[[gnu::always_inline]] inline void products_on(const Block& a, const Block& b, double* c,
                                               Index c_stride) {
  Index j = 0;
  for (; j + 4 <= b.columns; j += 4)
    dot_columns<L, 4, false>(a, 0, b.data + j * b.stride, b.stride, c + j * c_stride, c_stride);
  for (; j < b.columns; ++j)
    dot_columns<L, 1, false>(a, 0, b.data + j * b.stride, b.stride, c + j * c_stride, c_stride);
}

// K vectors of rows of J columns of B.
template <class L, int K, int J>
[[gnu::always_inline]] inline void subtract_tile(const Block& v, const double* w, Index w_stride,
                                                 double* b, Index b_stride, Index row) {
  using Vector = typename L::Vector;
  using Loose = typename L::Loose;
  Vector rest[K][J];
  DRIFTWISE_UNROLLED
  for (int k = 0; k < K; ++k) {
    DRIFTWISE_UNROLLED
    for (int j = 0; j < J; ++j)
      rest[k][j] = *reinterpret_cast<Loose*>(b + j * b_stride + row + k * L::kCount);
  }
  for (Index p = 0; p < v.columns; ++p) {
    Vector column[K];
    DRIFTWISE_UNROLLED
    for (int k = 0; k < K; ++k)
      column[k] = *reinterpret_cast<const Loose*>(v.data + p * v.stride + row + k * L::kCount);
    DRIFTWISE_UNROLLED
    for (int j = 0; j < J; ++j) {
      const double factor = w[j * w_stride + p];
      DRIFTWISE_UNROLLED
      for (int k = 0; k < K; ++k) rest[k][j] -= column[k] * factor;
    }
  }
  DRIFTWISE_UNROLLED
  for (int k = 0; k < K; ++k) {
    DRIFTWISE_UNROLLED
    for (int j = 0; j < J; ++j)
      *reinterpret_cast<Loose*>(b + j * b_stride + row + k * L::kCount) = rest[k][j];
  }
}

template <class L, int J>
[[gnu::always_inline]] inline void subtract_columns(const Block& v, const double* w, Index w_stride,
                                                    double* b, Index b_stride, Index rows) {
  Index row = 0;
  for (; row + 4 * L::kCount <= rows; row += 4 * L::kCount)
    subtract_tile<L, 4, J>(v, w, w_stride, b, b_stride, row);
  for (; row < rows; row += L::kCount) subtract_tile<L, 1, J>(v, w, w_stride, b, b_stride, row);
}

template <class L>
[[gnu::always_inline]] inline void subtract_product_on(const Block& v, const double* w,
                                                       Index w_stride, const Block& b) {
  Index j = 0;
  for (; j + 4 <= b.columns; j += 4)
    subtract_columns<L, 4>(v, w + j * w_stride, w_stride, b.data + j * b.stride, b.stride, b.rows);
  for (; j < b.columns; ++j)
    subtract_columns<L, 1>(v, w + j * w_stride, w_stride, b.data + j * b.stride, b.stride, b.rows);
}

struct Kernels {
  void (*add_gram)(const Block&, double*);
  void (*products)(const Block&, const Block&, double*, Index);
  void (*subtract_product)(const Block&, const double*, Index, const Block&);
};

#define DRIFTWISE_KERNELS(name, target, lanes)                                             \
  target void add_gram_##name(const Block& x, double* gram) {                              \
    add_gram_on<Lanes<lanes>>(x, gram);                                                    \
  }                                                                                        \
  target void products_##name(const Block& a, const Block& b, double* c, Index c_stride) { \
    products_on<Lanes<lanes>>(a, b, c, c_stride);                                          \
  }                                                                                        \
  target void subtract_product_##name(const Block& v, const double* w, Index w_stride,     \
                                      const Block& b) {                                    \
    subtract_product_on<Lanes<lanes>>(v, w, w_stride, b);                                  \
  }                                                                                        \
  constexpr Kernels kernels_##name = {add_gram_##name, products_##name, subtract_product_##name};

DRIFTWISE_KERNELS(plain, , 2)
#if defined(__x86_64__)
DRIFTWISE_KERNELS(avx2, __attribute__((target("avx2,fma"))), 4)
DRIFTWISE_KERNELS(avx512, __attribute__((target("avx512f"))), 8)
#endif

const Kernels& kernels() {
#if defined(__x86_64__)
  static const Kernels* const chosen =
      __builtin_cpu_supports("avx512f")                                 ? &kernels_avx512
      : __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? &kernels_avx2
                                                                        : &kernels_plain;
  return *chosen;
#else
  return kernels_plain;
#endif
}

}  // namespace

void add_gram(const Block& x, double* gram) { kernels().add_gram(x, gram); }

void products(const Block& a, const Block& b, double* c, Index c_stride) {
  kernels().products(a, b, c, c_stride);
}

void subtract_product(const Block& v, const double* w, Index w_stride, const Block& b) {
  kernels().subtract_product(v, w, w_stride, b);
}

}  // namespace driftwise::calibration::tall
