#include "server/diagnosis/catalogue/physics.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "server/core/units.h"
#include "server/diagnosis/catalogue/linear_parameter.h"
#include "server/diagnosis/noise/robust.h"
#include "server/diagnosis/rows/held_out_gain.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();
constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"}, kTilts = {"rx", "ry", "rz"};

// Steel 11.7, aluminium 23.6, invar 1.2 ppm/K (Kaye and Laby, section 2.3.5).
constexpr double kExpansion_ppm_per_k = 12, kLargestExpansion_ppm_per_k = 30;
constexpr double kSmallestMachine_mm = 100;   // of what carries a short stage
constexpr double kUnknownMachine_mm = 1000;   // where the file has no coordinate: of machine tools
constexpr double kRateTime_h = 900.0 / 3600;  // of a delay that shows as a rate
constexpr double kHeating_k = 0.3;            // of a motor's surroundings
constexpr double kActivity_k = 1;             // of a spindle's
constexpr double kGeometry = 1e-4;            // of the stroke: straightness and scale of stages
constexpr double kPlay = 2e-5, kPlay_nm = 200;
constexpr double kWave_nm = 20, kWaveOfAngle = 0.01, kWaveOfPeriod = 1e-3, kWaveOfStroke = 1e-5;
constexpr double kCompliance_nm_per_n = 100;  // 10 N/um
// A steel ball of 10 mm on a flat approaches by (9 / (16 R E'^2))^(1/3) F^(2/3), R = 5 mm and
// E' = 115 GPa: 204 nm at 1 N (Johnson, Contact Mechanics, 4.2).
constexpr double kContact_nm = 200;
constexpr double kLever_mm = 20, kDeadPath_mm = 100, kBeam_mm = 500;
// A beam at an angle walks off by twice angle x stroke on its way there and back: by half of an
// aperture of 6 mm it is lost. Nothing is mounted worse than by a degree.
constexpr double kBeamWalk_mm = 3, kWorstMount_arcsec = 3600, kOfWorstBeam = 1.0 / 3;
constexpr double kDrift_nm_per_h = 50;
// Of a helium-neon tube that warms up: it sweeps its gain curve, 1.5 GHz or 3 ppm, within hours.
// Air that nobody measures is next (0.6, by Edlen's coefficients below, of 1 hPa and a third of a
// kelvin in an hour), a stabilised laser last (0.02): the smaller shares of this width.
constexpr double kScaleDrift_ppm_per_h = 1;
constexpr double kJump_nm = 316.4;  // half a wavelength of a helium-neon laser
// Refractivity of air at 20 degC, 1013.25 hPa, 50 % (Edlen; Birch and Downs 1994).
constexpr double kAir_ppm_per_k = 0.95, kAir_ppm_per_hpa = 0.27, kAir_ppm_per_pct = 0.01;
constexpr double kFreeShape = 0.5;  // of the noise of a row
constexpr double kOfNoise = 10;     // what is neither declared nor known, over the noise of a row
constexpr double kRange = 20;       // of a typical size, where physics sets no sharper end

// Of the three names, the one that the term reads; -1: none.
int read_by(const effects::Term& term, const std::array<const char*, 3>& names) {
  for (const auto& symbol : effects::symbols_of(term))
    for (std::size_t i = 0; i < names.size(); ++i)
      if (symbol == names[i]) return static_cast<int>(i);
  return -1;
}

// The pose coordinate that the term reads; empty: none.
std::string axis_of(const effects::Term& term) {
  if (const int axis = read_by(term, kAxes); axis >= 0)
    return kAxes[static_cast<std::size_t>(axis)];
  if (const int tilt = read_by(term, kTilts); tilt >= 0)
    return kTilts[static_cast<std::size_t>(tilt)];
  return "";
}

double air_ppm(const effects::Term& term) {
  for (const auto& factor : term.factors) {
    if (const auto* call = std::get_if<effects::Call>(&factor);
        call != nullptr && call->effect == "air_index")
      return 1;
    if (const auto* power = std::get_if<effects::Power>(&factor)) {
      if (power->symbol == "air") return kAir_ppm_per_k;
      if (power->symbol == "pressure") return kAir_ppm_per_hpa;
      if (power->symbol == "humidity") return kAir_ppm_per_pct;
    }
  }
  return 1;
}

int exponent_of(const effects::Term& term, const std::string& symbol) {
  for (const auto& factor : term.factors)
    if (const auto* power = std::get_if<effects::Power>(&factor);
        power != nullptr && power->symbol == symbol)
      return power->exponent;
  return 1;
}

bool is_contact(const effects::Term& term) {
  const auto* call = std::get_if<effects::Call>(&term.factors.front());
  return call != nullptr && call->effect == "contact";
}

// Output over x, y, z by least squares: enough to turn a limit along one into one of the other.
Eigen::MatrixXd slopes_of(const Problem& problem) {
  const auto rows = static_cast<Eigen::Index>(problem.learn.size());
  std::vector<Eigen::Index> axes;
  Eigen::MatrixXd pose = Eigen::MatrixXd::Ones(rows, 4);
  Eigen::Index count = 1;
  for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
    const auto values = problem.data().values_of(kAxes[axis]);
    if (values.empty()) continue;
    for (Eigen::Index i = 0; i < rows; ++i)
      pose(i, count) = values[problem.learn[static_cast<std::size_t>(i)]];
    const double first = pose(0, count);
    if (!pose.col(count).allFinite() || (pose.col(count).array() == first).all()) continue;
    axes.push_back(static_cast<Eigen::Index>(axis));
    ++count;
  }
  const auto outputs = static_cast<Eigen::Index>(problem.outputs.size());
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(outputs, 3);
  if (rows <= count) return slopes;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(pose.leftCols(count));
  for (Eigen::Index o = 0; o < outputs; ++o) {
    Eigen::VectorXd measured(rows);
    for (Eigen::Index i = 0; i < rows; ++i)
      measured[i] =
          problem.outputs[static_cast<std::size_t>(o)]
              .measured[static_cast<Eigen::Index>(problem.learn[static_cast<std::size_t>(i)])];
    const Eigen::VectorXd b = qr.solve(measured);
    for (std::size_t k = 0; k < axes.size(); ++k)
      slopes(o, axes[k]) = b[static_cast<Eigen::Index>(k) + 1];
  }
  return slopes;
}

}  // namespace

double noise_between_neighbours(const Problem& problem, std::size_t output,
                                const Eigen::MatrixXd& columns) {
  const Eigen::VectorXd left = residuals(problem, problem.outputs[output], columns);
  std::vector<double> apart, about;
  for (std::size_t i = 0; i < problem.learn.size(); ++i) {
    const double here = left[static_cast<Eigen::Index>(problem.learn[i])];
    about.push_back(here);
    if (i > 0)
      apart.push_back((here - left[static_cast<Eigen::Index>(problem.learn[i - 1])]) /
                      std::sqrt(2.0));
  }
  const double sd = std::min(robust_sd(apart), robust_sd(about));
  const double measured = problem.outputs[output].measured.cwiseAbs().maxCoeff();
  return std::max({sd, 1e-13 * (std::isfinite(measured) ? measured : 1), 1e-12});
}

Physics::Physics(const Problem& problem, const std::optional<LeverLimits>& levers)
    : problem_(problem), levers_(levers), slopes_(slopes_of(problem)) {
  for (const auto& column : problem.data().columns)
    if (column.channel.unit == "mm" &&
        (is_motor_symbol(column.channel.symbol) || is_pose_symbol(column.channel.symbol)))
      longest_stroke_mm_ = std::max(longest_stroke_mm_, range_of(column.channel.symbol));
  const auto& time_s = problem.timeline.time_s;
  if (time_s.size() > 1) hours_ = (time_s.maxCoeff() - time_s.minCoeff()) / 3600;
  force_range_ = range_of("force");
  for (std::size_t o = 0; o < problem.outputs.size(); ++o)
    between_neighbours_.push_back(noise_between_neighbours(problem, o, problem.base_columns));
}

// max - min over the rows that learn, in the channel's unit.
double Physics::range_of(const std::string& symbol) const {
  const auto values = problem_.data().values_of(symbol);
  if (values.empty()) return 0;
  double low = kUnlimited, high = -kUnlimited;
  for (const std::size_t row : problem_.learn) {
    if (!std::isfinite(values[row])) continue;
    low = std::min(low, values[row]);
    high = std::max(high, values[row]);
  }
  return std::max(high - low, 0.0);
}

// Of the output, for a millionth of the coordinate that the term reads: nm per mm is ppm, and a
// rotation's ppm are a share of what the output goes through with it.
double Physics::nm_per_ppm(const effects::Term& term, std::size_t output) const {
  const std::string axis = axis_of(term);
  if (axis.empty() || read_by(term, kAxes) >= 0) return 1;
  double low = kUnlimited, high = -kUnlimited;
  for (const std::size_t row : problem_.learn) {
    const double value = problem_.outputs[output].measured[static_cast<Eigen::Index>(row)];
    if (!std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  return high > low ? 1e-6 * (high - low) / std::max(range_of(axis), 1e-12) : 1;
}

// Of a Chebyshev polynomial's first coefficient, per symbol of these: a term of any order is as
// large at the stroke's end as one of the first.
double Physics::per_unit_at_the_end(const effects::Term& term,
                                    const std::vector<std::string>& symbols) const {
  double result = 1;
  for (const auto& symbol : symbols) {
    const int e = exponent_of(term, symbol);
    result *= std::pow(2.0, e - 1) / std::pow(std::max(range_of(symbol) / 2, 1e-12), e);
  }
  return result;
}

// The same of the pose coordinates in the term, over the first one's in the first order.
double Physics::of_first_order(const effects::Term& term) const {
  std::vector<std::string> pose = effects::symbols_of(term);
  std::erase_if(pose, [](const std::string& symbol) { return !is_pose_symbol(symbol); });
  if (pose.empty()) return 1;
  return per_unit_at_the_end(term, pose) * std::max(range_of(axis_of(term)) / 2, 1e-12);
}

double Physics::nm_per_unit(const Cause& cause, const effects::Term& term, double parameter,
                            double column_range, std::size_t output) const {
  const double sigma = between_neighbours_[output], large = kOfNoise * sigma;
  const double stroke_nm = nm_from_mm(longest_stroke_mm_);
  const double machine_mm = longest_stroke_mm_ > 0
                                ? std::max(2 * longest_stroke_mm_, kSmallestMachine_mm)
                                : kUnknownMachine_mm;
  const double per_k = kExpansion_ppm_per_k * machine_mm;
  const double per_column = 1 / std::max(column_range, 1e-300);
  const auto& id = cause.id;
  if (id == "thermal_offset" || id == "thermal_lag") return per_k;
  if (id == "thermal_rate") return per_k * kRateTime_h;
  if (id == "thermal_expansion")
    return kExpansion_ppm_per_k * nm_per_ppm(term, output) * of_first_order(term);
  if (id == "self_heating") return kHeating_k * per_k * per_column;
  if (id == "activity_heating") return kActivity_k * per_k * per_column;
  if (id == "backlash" || id == "probe_hysteresis")
    return std::max({kPlay_nm, kPlay * stroke_nm, large}) / parameter *
           (cause.parameter == "width_nm" ? kNmPerMm : 1) /
           (term.factors.size() > 1 ? std::max(range_of(axis_of(term)), 1e-12) : 1);
  if (id == "creep") return std::max(kGeometry * stroke_nm, large) * per_column;
  if (id == "cyclic_error")
    return std::max(
        {kWave_nm, std::min(kWaveOfPeriod * parameter, kWaveOfStroke * stroke_nm), 2 * sigma});
  if (id == "periodic_disturbance") return std::max(kWave_nm, 2 * sigma);
  if (id == "step_change") return std::max(kJump_nm, large);
  if (id == "instrument_drift")
    return term.factors.size() > 1 ? kScaleDrift_ppm_per_h * nm_per_ppm(term, output)
                                   : std::max(kDrift_nm_per_h, large / std::max(hours_, 1e-9));
  if (id == "geometry_order")
    return std::max(kGeometry * stroke_nm, large) *
           per_unit_at_the_end(term, effects::symbols_of(term));
  if (id.starts_with("force_")) {
    const double per_n = std::max(kCompliance_nm_per_n, large / std::max(force_range_, 1e-12));
    if (id == "force_compliance") return per_n;
    if (is_contact(term))
      return std::max(kContact_nm, large / std::pow(std::max(force_range_, 1e-12), 2.0 / 3));
    if (id == "force_nonlinearity")
      return 0.3 * per_n / std::pow(std::max(force_range_, 1e-12), exponent_of(term, "force") - 1);
    const std::string axis = axis_of(term);
    if (axis.empty()) return per_n;
    return per_n / std::max(range_of(axis), 1e-12) * of_first_order(term);
  }
  if (id == "abbe_offset") {
    const int tilt = read_by(term, kTilts);
    if (levers_ && tilt >= 0) {
      double nm = 0;
      for (int of = 0; of < 3; ++of) {
        const double limit =
            levers_->mm[static_cast<std::size_t>(of)][static_cast<std::size_t>(tilt)];
        const double slope = std::abs(slopes_(static_cast<Eigen::Index>(output), of));
        if (slope > 0) nm += slope * kRadPerArcsec * (std::isfinite(limit) ? limit / 3 : kLever_mm);
      }
      return nm;
    }
    return kLever_mm * kRadPerArcsec * kNmPerMm;
  }
  if (id == "cosine_error") {
    if (is_square(term)) return kRadPerArcsec * kRadPerArcsec * kNmPerMm * kBeam_mm / 2;
    const double lost_arcsec =
        kBeamWalk_mm / (2 * std::max(longest_stroke_mm_, 1e-3)) / kRadPerArcsec;
    const double arcsec = kOfWorstBeam * std::min(lost_arcsec, kWorstMount_arcsec);
    const double turned = arcsec * kRadPerArcsec * kRadPerArcsec * kNmPerMm;
    return term.factors.size() > 1 ? turned : turned * kBeam_mm;
  }
  if (id == "refractive_index")
    return air_ppm(term) * (read_by(term, kAxes) >= 0 ? 1 : kDeadPath_mm);
  return large * per_column;
}

double Physics::range_factor(const Cause& cause, const effects::Term& term,
                             std::size_t output) const {
  const auto& id = cause.id;
  if (id == "thermal_expansion") return kLargestExpansion_ppm_per_k / kExpansion_ppm_per_k;
  if (id == "abbe_offset") {
    if (!levers_ || read_by(term, kTilts) < 0) return kUnlimited;
    for (int of = 0; of < 3; ++of)  // a direction that no beam declares
      if (slopes_(static_cast<Eigen::Index>(output), of) != 0 &&
          std::isinf(levers_->mm[static_cast<std::size_t>(of)]
                                [static_cast<std::size_t>(read_by(term, kTilts))]))
        return kUnlimited;
    return 3;
  }
  if (id == "step_change") return kUnlimited;
  if (id.starts_with("force_") || id == "backlash" || id == "probe_hysteresis" || id == "creep")
    return 50;
  if (id == "instrument_drift") return 20;
  if (id == "cosine_error") return is_square(term) ? 10 : 1 / kOfWorstBeam;
  // Share of the measured path: at most the whole, of an instrument that corrects nothing.
  if (id == "refractive_index" && read_by(term, kAxes) >= 0) return 1;
  if (id == "cyclic_error" || id == "periodic_disturbance" || id == "refractive_index") return 10;
  return kRange;
}

AmplitudePrior Physics::prior(const Cause& cause, const std::vector<effects::Term>& terms,
                              double parameter,
                              const Eigen::Ref<const Eigen::MatrixXd>& columns) const {
  AmplitudePrior result;
  const auto count = static_cast<Eigen::Index>(terms.size());
  const auto outputs = static_cast<Eigen::Index>(problem_.outputs.size());
  result.typical = result.range = Eigen::MatrixXd::Zero(count, outputs);
  for (Eigen::Index o = 0; o < outputs; ++o) {
    const auto& output = problem_.outputs[static_cast<std::size_t>(o)];
    if (!may_act_on(cause, output.channel.symbol)) continue;
    for (Eigen::Index k = 0; k < count; ++k) {
      const auto& term = terms[static_cast<std::size_t>(k)];
      const double column_range = columns.col(k).maxCoeff() - columns.col(k).minCoeff();
      if (!(column_range > 0)) continue;
      const auto at = static_cast<std::size_t>(o);
      // The table is of lengths; of anything else only the noise is known.
      const bool length = output.unit == "nm";
      double typical = length ? nm_per_unit(cause, term, parameter, column_range, at)
                              : 2 * kOfNoise * between_neighbours_[at] / column_range;
      double factor = length ? range_factor(cause, term, at) : kUnlimited;
      // A signal of 36 arcsec that errs by 2 of them is broken; once a turn it is off its centre.
      if (cause.id == "cyclic_error" && cause.parameter == "period_arcsec" &&
          output.unit == "arcsec") {
        typical = std::min(typical, kWaveOfAngle * parameter);
        factor = 10;
      }
      // An error that turns back faster than its coordinate goes on would read backwards.
      double most = kUnlimited;
      if (cause.id == "cyclic_error" && cause.parameter == "period_nm" && length)
        most = parameter / (2 * std::numbers::pi) *
               std::max(1.0, slopes_.row(o).cwiseAbs().maxCoeff() / kNmPerMm);
      typical = std::min(typical, most / 3);
      result.typical(k, o) = typical;
      result.range(k, o) = std::min(typical * factor, most);
    }
  }
  return result;
}

Eigen::VectorXd Physics::shared_precision(const Eigen::MatrixXd& prior_sd,
                                          const std::vector<WhiteSd>& noise) {
  Eigen::VectorXd precision(prior_sd.rows());
  for (Eigen::Index k = 0; k < precision.size(); ++k) {
    double sum = 0, count = 0;
    for (Eigen::Index o = 0; o < prior_sd.cols(); ++o)
      if (prior_sd(k, o) > 0) {
        sum += std::log(whitened_precision(noise[static_cast<std::size_t>(o)], prior_sd(k, o)));
        count += 1;
      }
    precision[k] = count > 0 ? std::exp(sum / count) : 1e300;
  }
  return precision;
}

Eigen::MatrixXd Physics::of_free_shape(const Eigen::Ref<const Eigen::MatrixXd>& columns) const {
  Eigen::MatrixXd sd(columns.cols(), static_cast<Eigen::Index>(problem_.outputs.size()));
  for (Eigen::Index k = 0; k < columns.cols(); ++k)
    for (Eigen::Index o = 0; o < sd.cols(); ++o)
      sd(k, o) = kFreeShape * between_neighbours_[static_cast<std::size_t>(o)] /
                 std::max(columns.col(k).cwiseAbs().maxCoeff(), 1e-300);
  return sd;
}

}  // namespace driftwise::diagnosis
