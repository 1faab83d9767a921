#include "server/diagnosis/growth/told_from_geometry.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "server/core/units.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kShareBeyondGeometry = 0.5;
// 2 ln L of what no geometry spells, with the amplitudes that it was fitted with: four standard
// deviations.
constexpr double kSurelyBeyond = 16;
// A polynomial of this degree leaves 12 % of one and a half periods, half of two, and 85 % of two
// and a half. What has so few by itself is a wave; what should have eight has lost them on a
// lattice.
constexpr int kSmoothDegree = 4;
constexpr double kShareOfWave = 0.6, kManyPeriods = 8;
constexpr double kLeftOfWave = 0.1, kFewPeriods = 1.5;  // rms, beside the baseline
constexpr double kShareOfPlaces = 0.5, kFurtherApart = 10;
// Chi squared of a wave on one output from which it counts there: one in a hundred by chance.
constexpr double kShownChi2 = 9.2;
constexpr double kHardly = 2.33;     // standard deviations: one in a hundred
constexpr double kTurns = 0.5;       // rad: a wave's phase within its places
constexpr int kDegreeOfOneAxis = 6;  // of two axes 5, of three 4
constexpr Eigen::Index kFewestRowsPerMonomial = 5;
constexpr std::size_t kFewestRowsPerPlace = 3;
constexpr Eigen::Index kFewestWithin = 10;
constexpr double kUnlimited = std::numeric_limits<double>::infinity();
constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};

// All monomials of the axes that vary up to a total degree, each axis scaled to -1 .. 1: one row
// per block.
Eigen::MatrixXd geometry_of(const Problem& problem) {
  const auto rows = static_cast<Eigen::Index>(problem.data().rows);
  std::vector<Eigen::ArrayXd> axes;
  for (const char* axis : kAxes) {
    // As the motors predict it: a tilt moves what is measured, and the measured coordinate minus
    // the predicted one is the lever itself.
    const auto values = problem.prepared.conditions().values_of(axis);
    if (values.empty()) continue;
    double low = kUnlimited, high = -kUnlimited;
    for (const std::size_t row : problem.learn) {
      low = std::min(low, values[row]);
      high = std::max(high, values[row]);
    }
    if (!(high > low)) continue;
    axes.push_back((Eigen::Map<const Eigen::ArrayXd>(values.data(), rows) - (low + high) / 2) /
                   ((high - low) / 2));
  }
  const int degree = kDegreeOfOneAxis - static_cast<int>(axes.size()) + 1;
  std::vector<Eigen::ArrayXd> monomials = {Eigen::ArrayXd::Ones(rows)};
  std::vector<int> degrees = {0};
  for (const auto& axis : axes)
    for (std::size_t i = 0; i < monomials.size(); ++i) {  // those it appends too: its next power
      if (degrees[i] == degree) continue;
      monomials.push_back(monomials[i] * axis);
      degrees.push_back(degrees[i] + 1);
    }
  Eigen::MatrixXd columns(rows, static_cast<Eigen::Index>(monomials.size()));
  for (std::size_t i = 0; i < monomials.size(); ++i)
    columns.col(static_cast<Eigen::Index>(i)) = monomials[i].matrix();
  return problem.learned(columns);
}

double explained(const Eigen::MatrixXd& columns, const Eigen::VectorXd& series) {
  return series.squaredNorm() -
         (series - columns * columns.completeOrthogonalDecomposition().solve(series)).squaredNorm();
}

}  // namespace

ToldFromGeometry::ToldFromGeometry(const Problem& problem)
    : problem_(problem), geometry_(geometry_of(problem)) {
  motors_ = std::ranges::count_if(problem.data().columns, [](const DatasetColumn& column) {
    return is_motor_symbol(column.channel.symbol);
  });
}

bool ToldFromGeometry::turns_on_these_places(const Cause& cause, double period,
                                             const Eigen::MatrixXd& columns) const {
  const auto values = problem_.prepared.phase_values(cause.subject);
  if (values.empty()) return true;
  Eigen::MatrixXd smooth(static_cast<Eigen::Index>(values.size()), kSmoothDegree + 1);
  double low = kUnlimited, high = -kUnlimited;
  for (const std::size_t row : problem_.learn) {
    low = std::min(low, values[row]);
    high = std::max(high, values[row]);
  }
  const double range = cause.parameter == "period_nm" ? nm_from_mm(high - low) : high - low;
  if (range >= kFewPeriods * period) {
    const Eigen::MatrixXd base = problem_.learned(problem_.base_columns);
    const Eigen::MatrixXd left = columns - base * base.colPivHouseholderQr().solve(columns);
    if (left.norm() < kLeftOfWave * columns.norm()) return false;
  }
  if (!(range > kManyPeriods * period)) return true;
  for (std::size_t row = 0; row < values.size(); ++row) {
    const double place = (2 * values[row] - low - high) / (high - low);
    for (int k = 0; k <= kSmoothDegree; ++k)
      smooth(static_cast<Eigen::Index>(row), k) = std::pow(place, k);
  }
  const Eigen::MatrixXd known = problem_.learned(smooth);
  const Eigen::MatrixXd wave = columns.rowwise() - columns.colwise().mean();
  const Eigen::MatrixXd beyond = wave - known * known.colPivHouseholderQr().solve(wave);
  return beyond.squaredNorm() >= kShareOfWave * wave.squaredNorm();
}

std::optional<ToldFromGeometry::Places> ToldFromGeometry::places_of(const Cause& cause,
                                                                    double parameter) const {
  const auto values = problem_.prepared.phase_values(cause.subject);
  if (values.empty()) return std::nullopt;
  const double period = cause.parameter == "period_nm" ? mm_from_nm(parameter) : parameter;
  std::vector<std::size_t> order = problem_.learn;
  std::ranges::sort(order, {}, [&](std::size_t row) { return values[row]; });
  std::vector<double> result(values.size(), 0);
  double longest = 0, apart = kUnlimited;
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin + 1;
    while (end < order.size() && values[order[end]] - values[order[end - 1]] < period / 2) ++end;
    longest = std::max(longest, values[order[end - 1]] - values[order[begin]]);
    if (end < order.size()) apart = std::min(apart, values[order[end]] - values[order[end - 1]]);
    double sum = 0;
    for (std::size_t i = begin; i < end; ++i) sum += values[order[i]];
    for (std::size_t i = begin; i < end; ++i)
      result[order[i]] = sum / static_cast<double>(end - begin);
    begin = end;
  }
  if (!(apart < kUnlimited) || apart < kFurtherApart * longest) return std::nullopt;
  return Places{{values.begin(), values.end()}, std::move(result), period};
}

bool ToldFromGeometry::goes_with_its_places(const Places& where, const Eigen::MatrixXd& columns,
                                            const std::vector<std::size_t>& shape,
                                            const Ground& ground) const {
  if (motors_ < 2) return true;
  const auto& [values, places, own] = where;
  Eigen::MatrixXd there(static_cast<Eigen::Index>(places.size()), 2);
  double squares = 0;
  for (const std::size_t row : problem_.learn)
    squares += std::pow(2 * std::numbers::pi * (values[row] - places[row]) / own, 2);
  const double turned = std::sqrt(squares / static_cast<double>(problem_.learn.size()));
  for (std::size_t row = 0; row < places.size(); ++row) {
    const double phase = 2 * std::numbers::pi * std::remainder(places[row] / own, 1.0);
    there.row(static_cast<Eigen::Index>(row)) << std::sin(phase), std::cos(phase);
  }
  const Eigen::MatrixXd at_places = problem_.learned(there);
  double plain = 0, of_wave = 0, of_data = 0;  // of_: explained with each row at its place
  for (std::size_t o = 0; o < shape.size(); ++o) {
    const auto at = static_cast<Eigen::Index>(o);
    const auto& space = ground.space(shape[o], at);
    const double weight = std::pow(ground.white_sd(at).value, -2);
    const Eigen::VectorXd left = space.left_over(ground.series().col(at));
    const Eigen::MatrixXd white = space.left_over(columns);
    const Eigen::VectorXd wave = white * white.completeOrthogonalDecomposition().solve(left);
    const Eigen::MatrixXd white_at_places = space.left_over(at_places);
    plain += wave.squaredNorm() * weight;
    of_wave += explained(white_at_places, wave) * weight;
    of_data += explained(white_at_places, left) * weight;
  }
  // Two cases: the phase hardly turns within a place, and all of a true wave is at the places; or
  // it turns, and as much of the data's as of the wave's own is there.
  return of_data >= kShareOfPlaces * (turned < kTurns ? plain : of_wave);
}

// Free values of the places against the wave. By evidence each value costs ln(1 + its share of what
// they explain), the factor by which the data narrow it; and chance gives each 1.
bool ToldFromGeometry::explains_its_places(const Places& where, const Eigen::MatrixXd& columns,
                                           const std::vector<std::size_t>& shape,
                                           const Ground& ground) const {
  const auto& [values, places, own] = where;
  std::vector<double> different;
  for (const std::size_t row : problem_.learn) different.push_back(places[row]);
  std::ranges::sort(different);
  different.erase(std::ranges::unique(different).begin(), different.end());
  const std::size_t count = different.size();
  if (count < 2 || kFewestRowsPerPlace * count > problem_.learn.size()) return true;
  if (different.back() - different.front() < kManyPeriods * own ||
      different.back() - different.front() < own * static_cast<double>(count - 1))
    return true;  // the places show the wave's course
  Eigen::MatrixXd at_place = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(places.size()),
                                                   static_cast<Eigen::Index>(count));
  for (const std::size_t row : problem_.learn)
    at_place(static_cast<Eigen::Index>(row),
             std::ranges::lower_bound(different, places[row]) - different.begin()) = 1;
  const Eigen::MatrixXd levels = problem_.learned(at_place);
  double by_levels = 0, by_wave = 0, freedom = 0;
  for (std::size_t o = 0; o < shape.size(); ++o) {
    const auto at = static_cast<Eigen::Index>(o);
    const auto& space = ground.space(shape[o], at);
    const Eigen::VectorXd left = space.left_over(ground.series().col(at));
    const Eigen::MatrixXd basis = beyond(space, levels);
    const double of_levels = (basis.transpose() * left).squaredNorm();
    const auto within = left.size() - basis.cols() - problem_.base_columns.cols();
    if (within < kFewestWithin) return true;
    // By what rows at one place differ: the ground's noise has the effect in it.
    const double weight = static_cast<double>(within) / (left.squaredNorm() - of_levels);
    const double of_wave = explained(space.left_over(columns), left) * weight;
    if (of_wave < kShownChi2) continue;
    by_wave += of_wave;
    by_levels += of_levels * weight;
    freedom += static_cast<double>(basis.cols());
  }
  const double further = freedom - static_cast<double>(columns.cols());
  if (!(further > 0)) return true;  // fewer places than a wave takes
  const double cost = further * std::log1p(by_levels / freedom);
  const double chance =
      further + kHardly * std::sqrt(2 * further) + 2 * (kHardly * kHardly - 1) / 3;
  return by_levels - by_wave <= std::max(cost, chance);
}

bool ToldFromGeometry::operator()(const Cause& cause, double parameter,
                                  const Eigen::MatrixXd& columns,
                                  const std::vector<std::size_t>& shape,
                                  const Ground& ground) const {
  if (cause.id == "cyclic_error") {
    if (!turns_on_these_places(cause, parameter, columns)) return false;
    const auto where = places_of(cause, parameter);
    return !where || (goes_with_its_places(*where, columns, shape, ground) &&
                      explains_its_places(*where, columns, shape, ground));
  }
  if (cause.linear != LinearParameter::offset_mm && cause.linear != LinearParameter::angle_arcsec)
    return true;
  if (geometry_.cols() > geometry_.rows() / kFewestRowsPerMonomial) return true;
  double plain = 0, beyond_geometry = 0, own = 0, held = 0;
  for (std::size_t o = 0; o < shape.size(); ++o) {
    const auto at = static_cast<Eigen::Index>(o);
    const auto& space = ground.space(shape[o], at);
    const double weight = std::pow(ground.white_sd(at).value, -2);
    const Eigen::MatrixXd white = space.left_over(columns);
    const Eigen::VectorXd left = space.left_over(ground.series().col(at));
    const Eigen::MatrixXd basis = beyond(space, geometry_);
    const auto without_geometry = [&](const auto& what) -> Eigen::MatrixXd {
      return what - basis * (basis.transpose() * what);
    };
    const Eigen::VectorXd effect = white * white.completeOrthogonalDecomposition().solve(left);
    const Eigen::VectorXd of_effect = without_geometry(effect), rest = without_geometry(left);
    plain += explained(white, left) * weight;
    beyond_geometry += explained(without_geometry(white), rest) * weight;
    own += of_effect.squaredNorm() * weight;
    held += (2 * of_effect.dot(rest) - of_effect.squaredNorm()) * weight;
  }
  return beyond_geometry >= kShareBeyondGeometry * plain ||
         held >= std::max(kSurelyBeyond, kShareBeyondGeometry * own);
}

}  // namespace driftwise::diagnosis
