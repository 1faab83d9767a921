#include "server/correction/angle_drift.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "server/core/reasons.h"

namespace driftwise::correction {
namespace {

constexpr double kLeastSpan_k = 0.02;  // twice the stability of a good thermometer over a night
constexpr std::size_t kMoreThanDatums = 3;

struct Return {
  double k = 0, arcsec = 0;
};

tl::unexpected<Error> refused(Reason reason, std::string message) {
  return fail(ErrorCode::invalid_argument, reason, std::move(message));
}

std::string channels_with(const Dataset& dataset, bool (*fits)(const Channel&)) {
  std::string list;
  for (const auto& column : dataset.columns)
    if (fits(column.channel)) list += (list.empty() ? "" : ", ") + column.channel.symbol;
  return list.empty() ? "none" : list;
}

bool is_rotation(const Channel& channel) {
  return is_pose_symbol(without_robot(channel.symbol)) && is_angle(channel.unit);
}

// Usable returns by datum of their run.
std::map<std::pair<std::int64_t, std::int64_t>, std::vector<Return>> returns_of(
    const Dataset& dataset, const DatasetColumn& angle, const DatasetColumn& temperature) {
  const double arcsec_per_unit = summary_unit(angle.channel.unit).factor;
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<Return>> out;
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    if (dataset.zero[row] == 0 || dataset.is_excluded(row)) continue;
    const Return one{temperature.values[row], arcsec_per_unit * angle.values[row]};
    if (!std::isfinite(one.k) || !std::isfinite(one.arcsec)) continue;
    out[{dataset.run.empty() ? 0 : dataset.run[row],
         dataset.datum.empty() ? 0 : dataset.datum[row]}]
        .push_back(one);
  }
  return out;
}

}  // namespace

Result<AngleDrift> drift_from_returns(const Dataset& dataset, const std::string& axis,
                                      const std::string& thermometer) {
  const auto* angle = dataset.find(axis);
  if (angle == nullptr || !is_rotation(angle->channel))
    return refused(reasons::kUnknownChannel,
                   fmt::format("channel: found '{}', expected a rotation of the data: {}", axis,
                               channels_with(dataset, is_rotation)));
  const auto* temperature = dataset.find(thermometer);
  if (temperature == nullptr || !is_structure_temperature(temperature->channel))
    return refused(reasons::kUnknownChannel,
                   fmt::format("thermometer: found '{}', expected one of the data: {}", thermometer,
                               channels_with(dataset, is_structure_temperature)));
  if (dataset.zero.empty())
    return refused(reasons::kNoPoseZero,
                   "the data have no column zero, expected returns to zero, or state the drift");
  AngleDrift out;
  double kk = 0, ka = 0;
  const auto datums = returns_of(dataset, *angle, *temperature);
  std::vector<Return> centred;
  for (const auto& [datum, all] : datums) {
    Return mean;
    for (const auto& one : all) mean.k += one.k, mean.arcsec += one.arcsec;
    mean.k /= static_cast<double>(all.size()), mean.arcsec /= static_cast<double>(all.size());
    const auto [low, high] = std::ranges::minmax(all, {}, &Return::k);
    out.span_k = std::max(out.span_k, high.k - low.k);
    for (const auto& one : all) {
      centred.push_back({one.k - mean.k, one.arcsec - mean.arcsec});
      kk += centred.back().k * centred.back().k;
      ka += centred.back().k * centred.back().arcsec;
    }
  }
  out.returns = centred.size();
  out.datums = datums.size();
  if (out.returns < out.datums + kMoreThanDatums)
    return refused(reasons::kNoPoseZero,
                   fmt::format("found {} returns to zero in {} datums, expected {} more than "
                               "datums: measure a run with more of them, or state the drift",
                               out.returns, out.datums, kMoreThanDatums));
  if (out.span_k < kLeastSpan_k)
    return refused(reasons::kBadRange,
                   fmt::format("{} changes by {:.3f} K over the returns to zero of a datum, "
                               "expected {} K at least: a drift with it cannot be seen here",
                               thermometer, out.span_k, kLeastSpan_k));
  out.arcsec_per_k = ka / kk;
  double squares = 0;
  for (const auto& one : centred) {
    const double residual = one.arcsec - out.arcsec_per_k * one.k;
    squares += residual * residual;
  }
  out.residual_arcsec = std::sqrt(squares / static_cast<double>(out.returns - out.datums - 1));
  out.u_arcsec_per_k = out.residual_arcsec / std::sqrt(kk);
  return out;
}

AngleShift shift_from(const AngleDrift& drift, const std::string& axis,
                      const std::string& thermometer, std::string source, std::vector<RunId> runs) {
  AngleShift shift;
  shift.axis = axis;
  shift.terms = {effects::Term{{effects::Power{thermometer, 1}}}};
  shift.arcsec = {drift.arcsec_per_k};
  shift.u_arcsec = {drift.u_arcsec_per_k};
  shift.source = std::move(source);
  shift.runs = std::move(runs);
  return shift;
}

}  // namespace driftwise::correction
