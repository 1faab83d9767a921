#include "server/calibration/row_qr.h"

#include <Eigen/QR>
#include <algorithm>

namespace driftwise::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr Index kChains =
    8;  // that may run at once; fixed, so that threads do not change the result

MatrixXd triangle_of(MatrixXd& rows) {
  const Index kept = std::min(rows.rows(), rows.cols());
  Eigen::HouseholderQR<Eigen::Ref<MatrixXd>> qr(rows);
  return rows.topRows(kept).template triangularView<Eigen::Upper>();
}

// 512 kB of rows: they stay in the second-level cache while the reflections pass over them.
Index block_rows(Index width) {
  return std::max<Index>(65536 / std::max<Index>(width, 1), 2 * width);
}

MatrixXd chain(const Eigen::Ref<const MatrixXd>& matrix) {
  const Index width = matrix.cols(), step = block_rows(width);
  MatrixXd triangle(0, width);
  MatrixXd buffer;
  for (Index at = 0; at < matrix.rows(); at += step) {
    const Index count = std::min(step, matrix.rows() - at);
    buffer.resize(triangle.rows() + count, width);
    buffer.topRows(triangle.rows()) = triangle;
    buffer.bottomRows(count) = matrix.middleRows(at, count);
    triangle = triangle_of(buffer);
  }
  return triangle;
}

}  // namespace

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
  return triangle_of(stacked);
}

MatrixXd row_qr(const Eigen::Ref<const MatrixXd>& matrix, const Executor& executor) {
  const Index blocks = matrix.rows() / block_rows(matrix.cols());
  if (blocks < 2 * kChains) return chain(matrix);
  std::vector<MatrixXd> parts(kChains);
  const auto job = [&](std::size_t part) {
    const auto index = static_cast<Index>(part);
    const Index begin = matrix.rows() * index / kChains,
                end = matrix.rows() * (index + 1) / kChains;
    parts[part] = chain(matrix.middleRows(begin, end - begin));
  };
  if (executor)
    executor(parts.size(), job);
  else
    for (std::size_t part = 0; part < parts.size(); ++part) job(part);
  return join_triangles(parts);
}

}  // namespace driftwise::calibration
