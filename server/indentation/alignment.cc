#include "server/indentation/alignment.h"

#include <Eigen/Dense>
#include <cmath>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/text/shown_text.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::indentation {
namespace {

constexpr double kSame_nm = 0.001;    // heights are counted in mm: their last digits are rounding
constexpr double kLeastWidth = 0.02;  // second extent of the points, in the first one

tl::unexpected<Error> bad(std::string reason, std::string message) {
  return fail(ErrorCode::invalid_argument, std::move(reason), std::move(message));
}

std::string tilts_text(const TouchPlane& plane) {
  return "rx " + digits_text(plane.rx_arcsec, 4) + " +- " + digits_text(plane.u_rx_arcsec, 2) +
         ", ry " + digits_text(plane.ry_arcsec, 4) + " +- " + digits_text(plane.u_ry_arcsec, 2) +
         " arcsec";
}

}  // namespace

Result<TouchPlane> fit_plane(std::span<const TouchPoint> points) {
  if (points.size() < 3)
    return bad(reasons::kTooFewPoints, "a plane needs 3 touched points, found " +
                                           std::to_string(points.size()) + ": touch more places");
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd place(n, 2), design(n, 3);
  Eigen::VectorXd height_mm(n), weight(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& p = points[static_cast<std::size_t>(i)];
    if (!std::isfinite(p.x_mm) || !std::isfinite(p.y_mm) || !std::isfinite(p.height_mm) ||
        !std::isfinite(p.u_nm) || !(p.u_nm > 0))
      return bad(reasons::kBadValue,
                 "touched point " + std::to_string(i + 1) +
                     " is not finite, or its uncertainty is not above 0: found x " +
                     number_text(p.x_mm) + ", y " + number_text(p.y_mm) + ", height " +
                     number_text(p.height_mm) + " mm, u " + number_text(p.u_nm) + " nm");
    place.row(i) << p.x_mm, p.y_mm;
    height_mm[i] = p.height_mm;
    weight[i] = 1 / mm_from_nm(p.u_nm);
  }
  const Eigen::RowVector2d middle = place.colwise().mean();
  const Eigen::MatrixXd about = place.rowwise() - middle;
  const Eigen::VectorXd extent = about.jacobiSvd().singularValues();
  if (!(extent[1] > kLeastWidth * extent[0]))
    return bad(reasons::kPointsOnALine,
               "the " + std::to_string(points.size()) +
                   " touched points lie on one line: the tilt about it is not "
                   "determined. Touch a point beside the line");
  design << Eigen::VectorXd::Ones(n), -about.col(1), about.col(0);
  const Eigen::MatrixXd weighted = weight.asDiagonal() * design;
  const Eigen::Vector3d found =
      weighted.colPivHouseholderQr().solve(weight.asDiagonal() * height_mm);
  const Eigen::Matrix3d covariance = (weighted.transpose() * weighted).inverse();
  if (!(std::abs(found[1]) < 1 && std::abs(found[2]) < 1))
    return bad(reasons::kBadValue,
               "the touched points lie on a slope of 45 degrees or more: check x, y "
               "and height, all in mm");
  // Tangents' derivatives at the solution: d rx = cos^2 rx d tan rx.
  const double rx_rad = std::atan(found[1]), ry_rad = std::atan(found[2]);
  const auto u_arcsec = [](double variance, double rad) {
    return arcsec_from_rad(std::sqrt(variance) * std::cos(rad) * std::cos(rad));
  };
  const Eigen::Vector3d at_origin(1, middle[1], -middle[0]);

  return TouchPlane{
      .c_mm = at_origin.dot(found),
      .rx_arcsec = arcsec_from_rad(rx_rad),
      .ry_arcsec = arcsec_from_rad(ry_rad),
      .u_rx_arcsec = u_arcsec(covariance(1, 1), rx_rad),
      .u_ry_arcsec = u_arcsec(covariance(2, 2), ry_rad),
      .largest_residual_nm = nm_from_mm((height_mm - design * found).cwiseAbs().maxCoeff()),
      .spread_nm = nm_from_mm(height_mm.maxCoeff() - height_mm.minCoeff())};
}

Result<AlignmentStep> next_alignment(const AlignmentRule& rule, int corrections, double rx_arcsec,
                                     double ry_arcsec, std::span<const TouchPoint> points) {
  DRIFTWISE_TRY(const auto plane, fit_plane(points));
  AlignmentStep step{.plane = plane, .rx_arcsec = rx_arcsec, .ry_arcsec = ry_arcsec};
  const std::string found = "contacts differ by " + quantity_text(plane.spread_nm, "nm") +
                            " (accepted: " + quantity_text(rule.accept_nm, "nm") + "), " +
                            tilts_text(plane);
  if (plane.spread_nm <= rule.accept_nm + kSame_nm) {
    step.kind = AlignmentStep::Kind::accepted;
    step.sentence = found + ": aligned after " + std::to_string(corrections) + " corrections";
  } else if (corrections >= rule.most_corrections) {
    step.kind = AlignmentStep::Kind::refused;
    step.sentence = found + " after " + std::to_string(corrections) +
                    " corrections: the robot below does not go where it is told, or the surface "
                    "is not a plane. Check its model, clean the surface, touch other places";
  } else {
    step.kind = AlignmentStep::Kind::correct;
    step.rx_arcsec = rx_arcsec - plane.rx_arcsec;
    step.ry_arcsec = ry_arcsec - plane.ry_arcsec;
    step.sentence = found + ": corrected by as much, the other way";
  }
  return step;
}

}  // namespace driftwise::indentation
