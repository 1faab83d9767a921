#include "server/diagnosis/growth/omnibus.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/noise/random_field.h"
#include "server/diagnosis/noise/shape_between.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kClip = 3.5;
// After so many series the test may end: more than so many of them are as large as the data.
struct Stage {
  int nulls, most;
};
constexpr std::array<Stage, 4> kStages = {{{24, 1}, {49, 1}, {99, 2}, {199, 3}}};
constexpr double kPower = 0.8416;  // normal quantile of 80 %
constexpr double kShortTau = 3;    // of the grid's shortest: no slow effect looks like it
constexpr Eigen::Index kMostFieldColumns = 128;

}  // namespace

Eigen::MatrixXf Omnibus::white(const SoftBase& base, Eigen::Index output, const NoiseShape& shape,
                               const Eigen::MatrixXd& series) const {
  const WhitenedSpace space(problem_.timeline, shape, independent_base(base), output);
  Eigen::MatrixXd left = space.left_over(series);
  const auto n = static_cast<double>(left.rows());
  const auto scale = [&] {
    for (Eigen::Index k = 0; k < left.cols(); ++k)
      left.col(k) /= std::max(left.col(k).norm() / std::sqrt(n), 1e-300);
  };
  for (int pass = 0; pass < 2; ++pass) {
    scale();
    left = left.cwiseMax(-kClip).cwiseMin(kClip);
    space.project(left);  // what was clipped is no part of the base either
  }
  scale();
  return left.cast<float>();
}

Eigen::MatrixXd Omnibus::forms(const Eigen::MatrixXf& left) const {
  const Eigen::Index series = left.cols(), n = left.rows();
  const auto bands = static_cast<Eigen::Index>(bands_.size());
  const Eigen::Index families = quadratic() + kLags + 1;
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(families, series);
  Eigen::MatrixXf turned(n, series), along(time_waves_.cols(), series);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const auto first = static_cast<Eigen::Index>(g) * bands;
    const auto take = [&] {
      for (Eigen::Index b = 0; b < bands; ++b) {
        const auto& band = bands_[static_cast<std::size_t>(b)];
        result.row(first + b) +=
            along.middleRows(band.first, band.count).colwise().squaredNorm().cast<double>();
      }
    };
    const auto& group = groups_[g];
    for (Eigen::Index w = 0; w < group.waves.cols(); ++w) {
      turned = group.waves.col(w).asDiagonal() * left;
      along.noalias() = time_waves_.transpose() * turned;
      take();
    }
    if (group.waves.cols() > 0) continue;
    std::vector<std::vector<Eigen::Index>> rows(place_count_);
    for (Eigen::Index i = 0; i < n; ++i) rows[place_of_[static_cast<std::size_t>(i)]].push_back(i);
    for (const auto& place : rows) {
      const Eigen::MatrixXf waves = time_waves_(place, Eigen::all), own = left(place, Eigen::all);
      along.noalias() = waves.transpose() * own;
      take();
    }
  }
  const Eigen::Index last = quadratic(), first_line = last - line_waves_.cols();
  if (line_waves_.cols() > 0)
    for (const auto& [first, count] : lines_) {
      along.noalias() =
          line_waves_.middleRows(first, count).transpose() * left.middleRows(first, count);
      result.middleRows(first_line, line_waves_.cols()) += along.cwiseAbs2().cast<double>();
    }
  for (Eigen::Index lag = 1; lag <= kLags; ++lag)
    result.row(last + lag - 1) =
        left.topRows(n - lag).cwiseProduct(left.bottomRows(n - lag)).colwise().sum().cast<double>();
  if (!by_place_.empty()) {
    const Eigen::MatrixXf sorted = left(by_place_, Eigen::all);
    result.row(last + kLags) =
        sorted.topRows(n - 1).cwiseProduct(sorted.bottomRows(n - 1)).colwise().sum().cast<double>();
  }
  return result;
}

// The noise as it is without a field, and what it may be with one: the likeliest of those that no
// slow field looks like, and white.
std::vector<NoiseShape> Omnibus::shapes_with_a_field(const Ground& ground) const {
  const auto grid = noise_grid(problem_.timeline);
  const double longest = grid.size() > 1 ? kShortTau * grid[1].tau_s : 0;
  std::vector<NoiseShape> shapes = {grid.front()};
  const auto add = [&](const NoiseShape& shape) {
    if (std::ranges::find(shapes, shape) == shapes.end()) shapes.push_back(shape);
  };
  for (Eigen::Index o = 0; o < ground.outputs(); ++o) {
    std::size_t best = 0;
    for (std::size_t s = 1; s < ground.shape_count(); ++s)
      if (ground.shape(s).tau_s <= longest && ground.worse_by(s, o) < ground.worse_by(best, o))
        best = s;
    add(ground.noise(o));
    add(ground.shape(best));
  }
  return shapes;
}

std::optional<Omnibus::Grown> Omnibus::grown(const RandomField& field,
                                             const std::vector<Eigen::MatrixXd>& series,
                                             const std::function<bool()>& tick) const {
  const RandomField::Seen seen = field.see(series);
  const Eigen::Index count = series.front().cols();
  Grown result{Eigen::VectorXd::Zero(count), Eigen::VectorXd::Zero(count), {}, {}};
  for (std::size_t g = 0; g < fields_.size(); ++g) {
    const auto& waves = fields_[g].waves;
    for (std::size_t b = 0; b < bands_.size(); ++b) {
      const auto& band = bands_[b];
      if (waves.cols() * band.count > kMostFieldColumns) break;
      if (tick && !tick()) return std::nullopt;
      Eigen::MatrixXd columns(waves.rows(), waves.cols() * band.count);
      for (Eigen::Index w = 0; w < waves.cols(); ++w)
        columns.middleCols(w * band.count, band.count) =
            (waves.col(w).asDiagonal() * time_waves_.middleCols(band.first, band.count))
                .cast<double>();
      const Eigen::MatrixXd growth = field.growth(columns, seen);
      Eigen::Index strongest = 0;
      growth.col(0).maxCoeff(&strongest);
      const Where here{g, b, strongest};
      const Eigen::VectorXd of_one = growth.colwise().maxCoeff().cwiseSqrt(),
                            of_all = growth.colwise().sum().cwiseSqrt();
      if (of_one[0] > result.of_one[0]) result.where_one = here;
      if (of_all[0] > result.of_all[0]) result.where_all = here;
      result.of_one = result.of_one.cwiseMax(of_one);
      result.of_all = result.of_all.cwiseMax(of_all);
    }
  }
  return result;
}

namespace {

// To mean 0 and spread 1 over the series.
Eigen::ArrayXd standardised(const Eigen::VectorXd& values) {
  const Eigen::ArrayXd about = values.array() - values.mean();
  return about / std::max(std::sqrt(about.square().mean()), 1e-300);
}

Eigen::VectorXd joined(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return (Eigen::VectorXd(a.size() + b.size()) << a, b).finished();
}

}  // namespace

// values: families x series.
Omnibus::Standardised Omnibus::standardise(Eigen::MatrixXd values) const {
  const Eigen::Index quadratic = this->quadratic();
  Standardised result;
  values.topRows(quadratic) = values.topRows(quadratic).array().max(0.0).pow(1.0 / 3);
  result.mean = values.rowwise().mean();
  values.colwise() -= result.mean;
  result.sd = (values.rowwise().squaredNorm() / static_cast<double>(values.cols())).cwiseSqrt();
  result.largest = Eigen::VectorXd::Constant(values.cols(), -1e300);
  result.of_data = Eigen::VectorXd::Constant(values.rows(), -1e300);
  for (Eigen::Index f = 0; f < values.rows(); ++f) {
    if (!(result.sd[f] > 1e-6 * std::abs(result.mean[f])) || !(result.sd[f] > 1e-9)) continue;
    Eigen::ArrayXd z = values.row(f).transpose().array() / result.sd[f];
    if (f >= quadratic) z = z.abs();
    result.of_data[f] = z[0];
    if (z[0] > result.largest[0]) result.family = static_cast<std::size_t>(f);
    result.largest = result.largest.cwiseMax(z.matrix());
  }
  return result;
}

std::optional<OmnibusResult> Omnibus::test(const SoftBase& base, const OmnibusOptions& options) {
  const auto grid = noise_grid(problem_.timeline);
  const Ground on_grid(problem_.timeline, grid, base, series_, options.tick);
  if (options.tick && !options.tick()) return std::nullopt;
  const Ground ground(problem_.timeline,
                      shapes_between(problem_.timeline, grid, on_grid, base, series_, options.tick),
                      base, series_);
  if (options.tick && !options.tick()) return std::nullopt;
  const Eigen::Index outputs = series_.cols();
  noise_.clear();
  white_sd_.clear();
  for (Eigen::Index o = 0; o < outputs; ++o) {
    noise_.push_back(ground.noise(o));
    white_sd_.push_back(ground.white_sd(o).value);
  }
  const Eigen::MatrixXd mixing = ground.correlation().llt().matrixL();
  std::mt19937_64 random(options.seed);
  std::vector<Eigen::MatrixXd> all(static_cast<std::size_t>(outputs));  // families x series
  std::vector<Eigen::VectorXf> own;
  const RandomField field(problem_.timeline, shapes_with_a_field(on_grid), base, kClip);
  Grown growths;
  OmnibusResult result;
  // Family and output of the largest of the data: of one output's form or field, of all together.
  enum Statistic : std::uint8_t { form, field_of_one, form_of_all, field_of_all };
  Statistic strongest = form;
  std::size_t family = 0, family_of_all = 0;
  Eigen::Index output = 0, output_of_all = 0;
  for (std::size_t stage = 0; stage <= kStages.size(); ++stage) {
    const int upto = stage < kStages.size() ? kStages[stage].nulls : options.nulls;
    const int more = std::min(upto, options.nulls) - result.nulls;
    if (more <= 0) continue;
    const bool with_data = result.nulls == 0;
    std::vector<Eigen::MatrixXd> series(static_cast<std::size_t>(outputs),
                                        Eigen::MatrixXd(series_.rows(), more + with_data));
    for (Eigen::Index k = 0; k < more + with_data; ++k) {
      const Eigen::MatrixXd drawn =
          with_data && k == 0
              ? series_
              : Eigen::MatrixXd(simulated_noise(problem_.timeline, noise_, mixing, random) +
                                drawn_hidden(base, outputs, random));
      for (Eigen::Index o = 0; o < outputs; ++o)
        series[static_cast<std::size_t>(o)].col(k) = drawn.col(o);
    }
    result.nulls += more;
    auto fields = grown(field, series, options.tick);
    if (!fields) return std::nullopt;
    if (with_data) {
      growths = std::move(*fields);
    } else {
      growths.of_one = joined(growths.of_one, fields->of_one);
      growths.of_all = joined(growths.of_all, fields->of_all);
    }
    for (Eigen::Index o = 0; o < outputs; ++o) {
      if (options.tick && !options.tick()) return std::nullopt;
      const auto at = static_cast<std::size_t>(o);
      const Eigen::MatrixXf left = white(base, o, noise_[at], series[at]);
      if (with_data) own.emplace_back(left.col(0));
      const Eigen::MatrixXd drawn = forms(left);
      all[at].conservativeResize(drawn.rows(), all[at].cols() + drawn.cols());
      all[at].rightCols(drawn.cols()) = drawn;
    }
    const Eigen::Index count = result.nulls + 1;
    Eigen::VectorXd largest = Eigen::VectorXd::Constant(count, -1e300);
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(all.front().rows(), count),
                    of_data(sum.rows(), outputs);
    mean_.clear();
    sd_.clear();
    for (Eigen::Index o = 0; o < outputs; ++o) {
      const auto& values = all[static_cast<std::size_t>(o)];
      Standardised one = standardise(values);
      if (one.largest[0] > largest[0]) family = one.family, output = o;
      largest = largest.cwiseMax(one.largest);
      sum += values;
      of_data.col(o) = one.of_data;
      mean_.push_back(std::move(one.mean));
      sd_.push_back(std::move(one.sd));
    }
    // The largest of them, each in units of its own spread over all series.
    std::vector<Eigen::ArrayXd> statistics = {standardised(largest), standardised(growths.of_one)};
    if (outputs > 1) {
      const Standardised together = standardise(std::move(sum));
      family_of_all = together.family;
      of_data.row(static_cast<Eigen::Index>(family_of_all)).maxCoeff(&output_of_all);
      statistics.push_back(standardised(together.largest));
      statistics.push_back(standardised(growths.of_all));
    }
    Eigen::ArrayXd most = statistics.front();
    strongest = form;
    for (std::size_t k = 1; k < statistics.size(); ++k) {
      if (statistics[k][0] > most[0]) strongest = static_cast<Statistic>(k);
      most = most.max(statistics[k]);
    }
    const auto as_large = (most.tail(result.nulls) >= most[0]).count();
    result.p = static_cast<double>(1 + as_large) / static_cast<double>(count);
    const Eigen::ArrayXd nulls = most.tail(result.nulls);
    const double gumbel =  // of 99.5 %
        nulls.mean() + 3.68 * std::sqrt((nulls - nulls.mean()).square().mean());
    const Eigen::ArrayXd about = largest.array() - largest.mean();
    limit_ = largest.mean() + gumbel * std::sqrt(about.square().mean());
    if (stage < kStages.size() && as_large > kStages[stage].most) break;
    if (result.p <= options.level) break;
  }
  if (result.p > options.level) {
    result.smallest = smallest(base);
    return result;
  }
  const auto& where = strongest == field_of_all ? growths.where_all : growths.where_one;
  if (strongest == field_of_one || strongest == field_of_all)
    result.where = words(fields_[where.field], bands_[where.band], where.output,
                         own[static_cast<std::size_t>(where.output)]);
  else if (strongest == form_of_all)
    result.where =
        words(family_of_all, output_of_all, own[static_cast<std::size_t>(output_of_all)]);
  else
    result.where = words(family, output, own[static_cast<std::size_t>(output)]);
  if (strongest == form_of_all || strongest == field_of_all)
    result.where += ", by all outputs together";
  return result;
}

Omnibus::FieldGain Omnibus::likeliest_field(const SoftBase& base) const {
  const Ground ground(problem_.timeline, noise_grid(problem_.timeline), base, series_);
  const RandomField field(problem_.timeline, shapes_with_a_field(ground), base, kClip);
  std::vector<Eigen::MatrixXd> series;
  for (Eigen::Index o = 0; o < series_.cols(); ++o) series.emplace_back(series_.col(o));
  const auto most = grown(field, series, {});
  return {most->of_one[0] * most->of_one[0], most->of_all[0] * most->of_all[0]};
}

double Omnibus::share_left(const SoftBase& with, const SoftBase& without) const {
  const Eigen::Index quadratic = this->quadratic();
  double most = 0, share = 0;
  for (Eigen::Index o = 0; o < series_.cols(); ++o) {
    const auto at = static_cast<std::size_t>(o);
    const auto scaled = [&](const SoftBase& base) {
      // In units of the noise that is left with everything in, not clipped to its own size.
      const WhitenedSpace space(problem_.timeline, noise_[at], independent_base(base), o);
      const Eigen::MatrixXf left = (space.left_over(series_.col(o)) / white_sd_[at]).cast<float>();
      return forms(left);
    };
    const Eigen::MatrixXd after = scaled(with), before = scaled(without);
    for (Eigen::Index f = 0; f < quadratic; ++f) {
      const double noise = std::pow(mean_[at][f], 3), taken = before(f, 0) - after(f, 0);
      const double spread = 3 * mean_[at][f] * mean_[at][f] * sd_[at][f];
      if (!(spread > 0) || !(taken / spread > most)) continue;
      most = taken / spread;
      share = std::max(after(f, 0) - noise, 0.0) / std::max(before(f, 0) - noise, 1e-300);
    }
  }
  return share;
}

// " (q2)"; nothing where there is one output.
std::string Omnibus::of_output(Eigen::Index output) const {
  return problem_.outputs.size() > 1
             ? " (" + problem_.outputs[static_cast<std::size_t>(output)].channel.symbol + ")"
             : "";
}

std::string Omnibus::words(std::size_t family, Eigen::Index output,
                           const Eigen::VectorXf& left) const {
  const std::size_t of_groups = groups_.size() * bands_.size(),
                    quadratic = static_cast<std::size_t>(this->quadratic());
  if (family >= of_groups && family < quadratic)
    return (family == of_groups ? "the lines of the plan, each by itself"
                                : "the beginning of the lines, each by itself") +
           of_output(output);
  if (family >= quadratic)
    return (family == quadratic + kLags ? "neighbouring places" : "neighbouring rows") +
           std::string(", which resemble or oppose each other more than noise does") +
           of_output(output);
  return words(groups_[family / bands_.size()], bands_[family % bands_.size()], output, left);
}

std::string Omnibus::words(const Group& group, const Band& band, Eigen::Index output,
                           const Eigen::VectorXf& left) const {
  std::string text = group.name;
  if (band.first > 0) text += std::string(text == "every row" ? " " : " and ") + "time";
  if (group.name == "every row") text = "time";
  // What the family describes, by quarters of the first coordinate and of the rows.
  const Eigen::Index n = left.size();
  Eigen::VectorXf field = Eigen::VectorXf::Zero(n);
  const auto waves = time_waves_.middleCols(band.first, band.count);
  for (Eigen::Index w = 0; w < group.waves.cols(); ++w) {
    const Eigen::MatrixXf features = group.waves.col(w).asDiagonal() * waves;
    field += features * (features.transpose() * left);
  }
  if (group.waves.cols() == 0)
    for (std::size_t place = 0; place < place_count_; ++place) {
      std::vector<Eigen::Index> rows;
      for (Eigen::Index i = 0; i < n; ++i)
        if (place_of_[static_cast<std::size_t>(i)] == place) rows.push_back(i);
      const Eigen::MatrixXf own = waves(rows, Eigen::all);
      field(rows) += own * (own.transpose() * left(rows));
    }
  std::string axis = group.of.empty() ? "" : group.of.front();
  if (axis.empty())
    for (const auto& other : groups_)
      if (other.of.size() == 1 && other.name.size() == 1 && is_pose_symbol(other.name)) {
        axis = other.name;
        break;
      }
  const auto values = problem_.prepared.conditions().values_of(axis);
  constexpr int kParts = 4;
  Eigen::Matrix<float, kParts, kParts> energy = decltype(energy)::Zero(), count = energy;
  Eigen::VectorXd at = Eigen::VectorXd::Zero(n);
  if (!values.empty())
    at = problem_.learned(
        Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
  const double low = at.minCoeff(), high = at.maxCoeff();
  for (Eigen::Index i = 0; i < n; ++i) {
    const int p =
        high > low ? std::min(kParts - 1, static_cast<int>(kParts * (at[i] - low) / (high - low)))
                   : 0;
    const int t = static_cast<int>(kParts * i / n);
    energy(p, t) += field[i] * field[i];
    count(p, t) += 1;
  }
  energy = energy.cwiseQuotient(count.cwiseMax(1));
  Eigen::Index p = 0, t = 0;
  energy.maxCoeff(&p, &t);
  char region[160] = "";
  if (high > low) {
    const auto* column = problem_.prepared.conditions().find(axis);
    std::snprintf(region, sizeof region, ", most at %s near %.3g %s", axis.c_str(),
                  low + (static_cast<double>(p) + 0.5) / kParts * (high - low),
                  column->channel.unit.c_str());
    text += region;
  }
  if (!problem_.data().time_s.empty() && band.first > 0) {
    const auto& time_s = problem_.timeline.time_s;
    std::snprintf(region, sizeof region, ", between %.3g and %.3g h of the data",
                  (time_s[t * n / kParts] - time_s[0]) / 3600,
                  (time_s[std::min(n - 1, (t + 1) * n / kParts)] - time_s[0]) / 3600);
    text += region;
  }
  return text + of_output(output);
}

// Approximately: the form of the shape alone adds to the noise's, whose spread grows with it.
std::vector<SmallestSeen> Omnibus::smallest(const SoftBase& base) const {
  const Eigen::Index n = problem_.timeline.rows();
  Eigen::VectorXd u = Eigen::VectorXd::Zero(n), t(n);
  for (Eigen::Index i = 0; i < n; ++i) t[i] = static_cast<double>(i) / static_cast<double>(n);
  for (const auto& column : problem_.prepared.conditions().columns)
    if (is_pose_symbol(column.channel.symbol) && is_length(column.channel.unit)) {
      const Eigen::VectorXd here = unit_range(problem_.learned(Eigen::Map<const Eigen::VectorXd>(
          column.values.data(), static_cast<Eigen::Index>(column.values.size()))));
      if (here.size() == 0) continue;
      u = here;
      break;
    }
  constexpr double kPi = std::numbers::pi;
  const Eigen::VectorXd bump = (-0.5 * ((u.array() - 0.4) / 0.08).square()).exp();
  const Eigen::VectorXd slow = (5 * kPi * t.array() + 0.6).sin();
  const Eigen::VectorXd joint = (8 * kPi * t.array()).sin() * (5 * kPi * u.array()).cos().sign();
  const Eigen::Index quadratic = this->quadratic();
  std::vector<SmallestSeen> result;
  const std::pair<const char*, const Eigen::VectorXd*> shapes[] = {
      {"a bump over a sixth of the first axis", &bump},
      {"a wave of two and a half periods over the data", &slow},
      {"four periods over the data with a sign that changes five times along the first axis",
       &joint}};
  for (const auto& [name, shape] : shapes) {
    if (shape->maxCoeff() - shape->minCoeff() < 1e-9) continue;
    for (Eigen::Index o = 0; o < series_.cols(); ++o) {
      const auto at = static_cast<std::size_t>(o);
      const WhitenedSpace space(problem_.timeline, noise_[at], independent_base(base), o);
      const double rms = std::sqrt((shape->array() - shape->mean()).square().mean());
      const Eigen::MatrixXd own =
          forms(space.left_over(Eigen::MatrixXd(*shape / (rms * white_sd_[at]))).cast<float>());
      double least = INFINITY;
      for (Eigen::Index f = 0; f < quadratic; ++f) {
        const double m3 = mean_[at][f], s3 = sd_[at][f];
        if (!(own(f, 0) > 0) || !(s3 > 1e-9)) continue;
        const double noise = m3 * m3 * m3, spread = 3 * m3 * m3 * s3;
        const double over = std::pow(m3 + limit_ * s3, 3) - noise;
        const double per = std::max(noise / static_cast<double>(n), 1.0);
        double a2 = over / own(f, 0);
        for (int i = 0; i < 20; ++i)
          a2 = (over + kPower * std::sqrt(spread * spread + 4 * a2 * own(f, 0) * per)) / own(f, 0);
        least = std::min(least, std::sqrt(a2));
      }
      if (std::isfinite(least))
        result.push_back(
            {name, problem_.outputs[at].channel.symbol, problem_.outputs[at].unit, least});
    }
  }
  return result;
}

}  // namespace driftwise::diagnosis
