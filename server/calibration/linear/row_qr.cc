#include "server/calibration/linear/row_qr.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "server/calibration/linear/tall_kernels.h"

namespace driftwise::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kPanel = 16;

MatrixXd triangle_of(MatrixXd& rows) {
  const Index kept = std::min(rows.rows(), rows.cols());
  Eigen::HouseholderQR<Eigen::Ref<MatrixXd>> qr(rows);
  return rows.topRows(kept).template triangularView<Eigen::Upper>();
}

// Reflections that take the panel's rows into rows [at, at + columns) of r; the panel becomes their
// vectors V (each below a one in r). Result: T of I - [I; V] T [I; V]' (Schreiber and Van Loan
// 1989).
MatrixXd reflect_panel(MatrixXd& r, Index at, const tall::Block& panel) {
  const Index count = panel.columns;
  VectorXd tau = VectorXd::Zero(count), weights(count);
  for (Index j = 0; j < count; ++j) {
    const tall::Block column = panel.from_column(j).head(1);
    double squares = 0;
    tall::products(column, column, &squares, 1);
    if (!(squares > 0)) continue;
    double& alpha = r(at + j, at + j);
    const double norm = std::sqrt(alpha * alpha + squares);
    const double beta = alpha > 0 ? -norm : norm;
    tau[j] = (beta - alpha) / beta;
    Eigen::Map<VectorXd>(column.data, column.rows) /= alpha - beta;
    alpha = beta;
    if (j + 1 == count) continue;
    const tall::Block rest = panel.from_column(j + 1);
    auto above = r.row(at + j).segment(at + j + 1, rest.columns);
    tall::products(column, rest, weights.data(), 1);
    weights.head(rest.columns) = tau[j] * (weights.head(rest.columns) + above.transpose());
    above -= weights.head(rest.columns).transpose();
    tall::subtract_product(column, weights.data(), 1, rest);
  }
  MatrixXd inner(count, count), t = MatrixXd::Zero(count, count);
  tall::products(panel, panel, inner.data(), count);
  for (Index j = 0; j < count; ++j) {
    t(j, j) = tau[j];
    if (j == 0) continue;
    const VectorXd before =
        t.topLeftCorner(j, j).template triangularView<Eigen::Upper>() * inner.col(j).head(j);
    t.col(j).head(j) = -tau[j] * before;
  }
  return t;
}

// R of [r; rows], r upper triangular of full width: only the rows below it are reflected.
void reflect_into(MatrixXd& r, const tall::Block& rows) {
  MatrixXd w;
  for (Index at = 0; at < rows.columns; at += kPanel) {
    const tall::Block panel = rows.from_column(at).head(std::min(kPanel, rows.columns - at));
    const MatrixXd t = reflect_panel(r, at, panel);
    const tall::Block rest = rows.from_column(at + panel.columns);
    if (rest.columns == 0) break;
    w.resize(panel.columns, rest.columns);
    tall::products(panel, rest, w.data(), panel.columns);
    auto above = r.block(at, at + panel.columns, panel.columns, rest.columns);
    w = t.transpose() * (w + above);
    above -= w;
    tall::subtract_product(panel, w.data(), panel.columns, rest);
  }
}

}  // namespace

Index block_rows(Index width) {
  constexpr Index kNumbers = 65536;  // 512 kB
  return tall::padded(std::max<Index>(kNumbers / std::max<Index>(width, 1), 2 * width));
}

void GrowingTriangle::add(MatrixXd& rows, Index count) {
  const Index width = triangle_.cols();
  if (triangle_.rows() == 0 && count >= width) triangle_ = MatrixXd::Zero(width, width);
  if (triangle_.rows() < width) {
    MatrixXd stacked(triangle_.rows() + count, width);
    stacked.topRows(triangle_.rows()) = triangle_;
    stacked.bottomRows(count) = rows.topRows(count);
    triangle_ = triangle_of(stacked);
    return;
  }
  rows.bottomRows(rows.rows() - count).setZero();
  reflect_into(triangle_, {rows.data(), rows.rows(), tall::padded(count), width});
}

MatrixXd row_qr(const Eigen::Ref<const MatrixXd>& matrix) {
  GrowingTriangle growing(matrix.cols());
  const Index step = block_rows(matrix.cols());
  MatrixXd buffer;
  for (Index at = 0; at < matrix.rows(); at += step) {
    const Index count = std::min(step, matrix.rows() - at);
    buffer.resize(tall::padded(count), matrix.cols());
    buffer.topRows(count) = matrix.middleRows(at, count);
    growing.add(buffer, count);
  }
  return growing.triangle();
}

MatrixXd join_triangles(const std::vector<MatrixXd>& triangles) {
  Index rows = 0, width = 0;
  for (const auto& triangle : triangles) {
    rows += triangle.rows();
    width = std::max(width, triangle.cols());
  }
  MatrixXd stacked(rows, width);
  Index at = 0;
  for (const auto& triangle : triangles) {
    stacked.middleRows(at, triangle.rows()) = triangle;
    at += triangle.rows();
  }
  return row_qr(stacked);
}

}  // namespace driftwise::calibration
