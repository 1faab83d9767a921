#include "server/correction/instrument_match.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <map>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/correction/robust.h"

namespace driftwise::correction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct CommonRows {
  std::vector<std::int64_t> row;
  std::vector<Index> of_reference, of_other;
};

struct Similarity {
  MatrixXd rotation;
  VectorXd offset_mm;  // at the origin of the reference
  double scale = 1;
  MatrixXd residual_mm;
};

Result<std::map<std::int64_t, Index>> index_of(const InstrumentRows& rows) {
  std::map<std::int64_t, Index> index;
  for (std::size_t k = 0; k < rows.row.size(); ++k)
    if (!index.emplace(rows.row[k], static_cast<Index>(k)).second)
      return fail(
          ErrorCode::invalid_argument, reasons::kDuplicateId,
          fmt::format("{}: row {} is there twice, expected each row once", rows.name, rows.row[k]));
  return index;
}

CommonRows common_rows(const std::map<std::int64_t, Index>& reference,
                       const std::map<std::int64_t, Index>& other, std::int64_t shift) {
  CommonRows common;
  for (const auto& [row, at] : reference) {
    const auto found = other.find(row + shift);
    if (found == other.end()) continue;
    common.row.push_back(row);
    common.of_reference.push_back(at);
    common.of_other.push_back(found->second);
  }
  return common;
}

// Umeyama with weights. Three axes need points that are not on a line, two need two places.
Result<Similarity> fitted(const MatrixXd& from, const MatrixXd& to, const VectorXd& weight,
                          const InstrumentRules& rules) {
  const Index axes = from.rows();
  const double total = weight.sum();
  const VectorXd from_mean = from * weight / total, to_mean = to * weight / total;
  const MatrixXd a = from.colwise() - from_mean, b = to.colwise() - to_mean;
  Similarity out;
  out.rotation = MatrixXd::Identity(axes, axes);
  if (rules.rotation && axes > 1) {
    const MatrixXd product = b * weight.asDiagonal() * a.transpose();
    const Eigen::JacobiSVD<MatrixXd> svd(product, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const auto& size = svd.singularValues();
    if (!(size[axes - 2] > 1e-10 * size[0]) || size[0] == 0)
      return fail(ErrorCode::failed_precondition, reasons::kPointsOnALine,
                  "the common points lie on a line: no rotation can be told from them "
                  "(--no-rotation fits scale and offset alone)");
    VectorXd signs = VectorXd::Ones(axes);
    if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0) signs[axes - 1] = -1;
    out.rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  }
  const MatrixXd turned = out.rotation * a;
  const double squares = (turned.cwiseAbs2() * weight).sum();
  if (rules.scale && squares > 0) out.scale = (turned.cwiseProduct(b) * weight).sum() / squares;
  out.offset_mm = to_mean - out.scale * out.rotation * from_mean;
  out.residual_mm = b - out.scale * turned;
  return out;
}

double rms(const MatrixXd& values) {
  return values.size() == 0 ? 0
                            : std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

Result<Similarity> fitted(const InstrumentRows& reference, const InstrumentRows& other,
                          const CommonRows& common, const InstrumentRules& rules) {
  VectorXd weight = VectorXd::Ones(static_cast<Index>(common.row.size()));
  for (std::size_t k = 0; k < common.row.size(); ++k) {
    double u2 = 0;
    if (reference.u_mm.size() > 0) u2 += std::pow(reference.u_mm[common.of_reference[k]], 2);
    if (other.u_mm.size() > 0) u2 += std::pow(other.u_mm[common.of_other[k]], 2);
    if (u2 > 0) weight[static_cast<Index>(k)] = 1 / u2;
  }
  weight /= weight.mean();
  return fitted(MatrixXd(reference.mm(Eigen::all, common.of_reference)),
                MatrixXd(other.mm(Eigen::all, common.of_other)), weight, rules);
}

Result<void> check_u(const InstrumentRows& rows) {
  for (Index k = 0; k < rows.u_mm.size(); ++k)
    if (!(rows.u_mm[k] > 0))
      return fail(ErrorCode::invalid_argument, reasons::kBadNumber,
                  fmt::format("{}: row {} states an uncertainty of {} mm, expected one above 0",
                              rows.name, rows.row[static_cast<std::size_t>(k)], rows.u_mm[k]));
  return {};
}

// Columns: offset (axes), rotation (1 of two axes, 3 of three), scale; of one row, mm per unit.
MatrixXd jacobian(const Similarity& fit, const VectorXd& reference_mm,
                  const InstrumentRules& rules) {
  const Index axes = reference_mm.size();
  const Index turns = !rules.rotation || axes == 1 ? 0 : axes == 2 ? 1 : 3;
  MatrixXd j = MatrixXd::Zero(axes, axes + turns + (rules.scale ? 1 : 0));
  j.leftCols(axes) = MatrixXd::Identity(axes, axes);
  const VectorXd turned = fit.rotation * reference_mm;
  if (turns == 1) j.col(axes) << -fit.scale * turned[1], fit.scale * turned[0];
  if (turns == 3)
    for (Index k = 0; k < 3; ++k)
      j.col(axes + k) =
          fit.scale * Eigen::Vector3d(Eigen::Vector3d::Unit(k)).cross(Eigen::Vector3d(turned));
  if (rules.scale) j.rightCols(1) = turned;
  return j;
}

void add_uncertainties(const Similarity& fit, const InstrumentRows& reference,
                       const InstrumentRows& other, const CommonRows& common,
                       const InstrumentRules& rules, InstrumentMatch& out) {
  const Index axes = fit.offset_mm.size();
  const bool states_u = reference.u_mm.size() > 0 || other.u_mm.size() > 0;
  MatrixXd normal;
  double chi2 = 0, count = 0;
  for (std::size_t k = 0; k < common.row.size(); ++k) {
    double u2 = states_u ? 0 : 1;
    if (reference.u_mm.size() > 0) u2 += std::pow(reference.u_mm[common.of_reference[k]], 2);
    if (other.u_mm.size() > 0) u2 += std::pow(other.u_mm[common.of_other[k]], 2);
    const auto j = jacobian(fit, reference.mm.col(common.of_reference[k]), rules);
    if (normal.size() == 0) normal = MatrixXd::Zero(j.cols(), j.cols());
    normal += j.transpose() * j / u2;
    chi2 += fit.residual_mm.col(static_cast<Index>(k)).squaredNorm() / u2;
    count += static_cast<double>(axes);
  }
  const double dof = std::max(1.0, count - static_cast<double>(normal.cols()));
  if (states_u) out.birge = std::sqrt(chi2 / dof);
  const MatrixXd covariance =
      normal.ldlt().solve(MatrixXd::Identity(normal.rows(), normal.cols())) * (chi2 / dof);
  const VectorXd u = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  out.u_offset_nm = u.head(axes) * kNmPerMm;
  const Index turns = normal.cols() - axes - (rules.scale ? 1 : 0);
  out.u_rotation_arcsec = u.segment(axes, turns) / kRadPerArcsec;
  if (rules.scale) out.u_scale_ppm = u[u.size() - 1] * 1e6;
  out.rotation_arcsec = VectorXd::Zero(turns);
  if (turns == 1)
    out.rotation_arcsec[0] = std::atan2(fit.rotation(1, 0), fit.rotation(0, 0)) / kRadPerArcsec;
  if (turns == 3) {
    const Eigen::AngleAxisd turn{Eigen::Matrix3d(fit.rotation)};
    out.rotation_arcsec = turn.angle() * turn.axis() / kRadPerArcsec;
  }
}

void add_findings(InstrumentMatch& out) {
  constexpr double kFar = 4;  // robust sigmas: 1 normal row of 16 000
  std::map<std::int64_t, std::string> far;
  for (Index axis = 0; axis < out.residual_nm.rows(); ++axis) {
    const auto& name = out.axes[static_cast<std::size_t>(axis)];
    std::vector<double> values(out.residual_nm.row(axis).begin(), out.residual_nm.row(axis).end());
    const double middle = median_of(values), sigma = sigma_of_most(values);
    for (std::size_t k = 0; k < values.size(); ++k)
      if (sigma > 0 && std::abs(values[k] - middle) > kFar * sigma)
        far[out.row[k]] +=
            fmt::format("{}{} {:+.1f} nm", far[out.row[k]].empty() ? "" : ", ", name, values[k]);
    // Rows in the order of the trajectory: a residual that keeps from one to the next is no noise.
    double product = 0, squares = 0;
    for (std::size_t k = 0; k < values.size(); ++k) {
      squares += values[k] * values[k];
      if (k > 0) product += values[k] * values[k - 1];
    }
    const double correlation = squares > 0 ? product / squares : 0;
    if (correlation > 3 / std::sqrt(static_cast<double>(values.size())))
      out.findings.push_back(fmt::format(
          "{}: residuals keep from one row to the next (correlation {:.2f}): a form that scale, "
          "offset and rotation do not have; the stated u are too small",
          name, correlation));
  }
  if (far.empty()) return;
  std::string rows;
  std::size_t told = 0;
  for (const auto& [row, text] : far)
    if (told++ < 8) rows += fmt::format("{}row {} ({})", rows.empty() ? "" : "; ", row, text);
  out.findings.push_back(fmt::format("{} of {} rows lie beyond {} robust standard deviations: {}{}",
                                     far.size(), out.row.size(), kFar, rows,
                                     far.size() > 8 ? "; ..." : ""));
}

// Rows of another trajectory, or a table that begins a row late, agree better elsewhere.
Result<void> check_shift(const std::map<std::int64_t, Index>& reference_index,
                         const std::map<std::int64_t, Index>& other_index,
                         const InstrumentRows& reference, const InstrumentRows& other,
                         const InstrumentRules& rules, double left_mm) {
  for (const std::int64_t shift : {-3, -2, -1, 1, 2, 3}) {
    const auto moved = common_rows(reference_index, other_index, shift);
    if (moved.row.size() < rules.least_rows) continue;
    const auto fit = fitted(reference, other, moved, rules);
    if (fit && 2 * rms(fit->residual_mm) < left_mm)
      return fail(ErrorCode::failed_precondition, reasons::kRowsShifted,
                  fmt::format("{} agrees with {} to {:.1f} nm, and to {:.1f} nm when its rows are "
                              "moved by {}: number its rows by the trajectory",
                              other.name, reference.name, left_mm * kNmPerMm,
                              rms(fit->residual_mm) * kNmPerMm, -shift));
  }
  return {};
}

}  // namespace

Result<InstrumentMatch> match_instruments(const InstrumentRows& reference,
                                          const InstrumentRows& other,
                                          const std::vector<std::string>& axes,
                                          const InstrumentRules& rules) {
  DRIFTWISE_TRY(const auto reference_index, index_of(reference));
  DRIFTWISE_TRY(const auto other_index, index_of(other));
  DRIFTWISE_RETURN_IF_ERROR(check_u(reference));
  DRIFTWISE_RETURN_IF_ERROR(check_u(other));
  const auto common = common_rows(reference_index, other_index, 0);
  if (common.row.size() < rules.least_rows || 2 * common.row.size() < other_index.size())
    return fail(ErrorCode::failed_precondition, reasons::kNoCommonRows,
                fmt::format("{} has {} rows, {} has {}, and {} are in both: expected at least {}, "
                            "and half of the second table's",
                            reference.name, reference_index.size(), other.name, other_index.size(),
                            common.row.size(), rules.least_rows));
  DRIFTWISE_TRY(const auto fit, fitted(reference, other, common, rules));
  DRIFTWISE_RETURN_IF_ERROR(
      check_shift(reference_index, other_index, reference, other, rules, rms(fit.residual_mm)));
  InstrumentMatch out;
  out.axes = axes;
  out.row = common.row;
  out.reference_only = reference_index.size() - common.row.size();
  out.other_only = other_index.size() - common.row.size();
  out.scale_ppm = (fit.scale - 1) * 1e6;
  out.offset_nm = fit.offset_mm * kNmPerMm;
  out.rotation = fit.rotation;
  out.residual_nm = fit.residual_mm * kNmPerMm;
  out.rms_nm = (out.residual_nm.cwiseAbs2().rowwise().mean()).cwiseSqrt();
  add_uncertainties(fit, reference, other, common, rules, out);
  add_findings(out);
  return out;
}

}  // namespace driftwise::correction
