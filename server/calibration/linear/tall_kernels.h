#pragma once
// The inner loops of a fit, on tall blocks of few columns that fit a core's second-level cache:
// compiled for AVX-512, AVX2 and the plain instruction set, chosen once by what the processor has.
// Between such processors results differ in the last bits (order of sums, fused products); on one
// they never do.
//
// A block is column-major with `stride` doubles from one column to the next. Its number of rows is
// a multiple of kLanes; who has fewer fills up with rows of zeros. No function allocates.

#include <cstddef>

namespace driftwise::calibration::tall {

using Index = std::ptrdiff_t;  // as Eigen::Index

constexpr Index kLanes = 8;
constexpr Index padded(Index rows) { return (rows + kLanes - 1) / kLanes * kLanes; }

struct Block {
  double* data;
  Index stride, rows, columns;
  Block from_column(Index first) const {
    return {data + first * stride, stride, rows, columns - first};
  }
  Block head(Index count) const { return {data, stride, rows, count}; }
};

// gram (columns x columns, stride columns) += X'X; the lower triangle only.
void add_gram(const Block& x, double* gram);

// c (a.columns x b.columns, column-major, stride c_stride) = A'B.
void products(const Block& a, const Block& b, double* c, Index c_stride);

// B -= V W, W: v.columns x b.columns, column-major, stride w_stride.
void subtract_product(const Block& v, const double* w, Index w_stride, const Block& b);

}  // namespace driftwise::calibration::tall
