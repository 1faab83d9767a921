#include "server/diagnosis/growth/omnibus.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "server/diagnosis/catalogue/cause.h"
#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/noise/random_field.h"
#include "server/diagnosis/rows/motor_places.h"

namespace driftwise::diagnosis {
namespace {

constexpr Eigen::Index kMostWaves = 127, kRowsPerWave = 4;
constexpr int kAxisWaves = 8, kPairWaves = 3, kTripleWaves = 2, kConditionWaves = 3;
constexpr double kClip = 3.5;
constexpr int kFirstNulls = 49, kClearlyNoise = 4;  // of the first as large as the data
constexpr double kPower = 0.8416;                   // normal quantile of 80 %
constexpr Eigen::Index kLags = 3;
constexpr double kShortTau = 3;  // of the grid's shortest: no slow effect looks like it
constexpr Eigen::Index kMostFieldColumns = 128;
constexpr int kSmoothWaves = 3, kMemoryWaves = 2;

Eigen::VectorXf wave(const Eigen::VectorXd& u, int k) {
  return (std::numbers::sqrt2 * (std::numbers::pi * k * u.array()).cos()).cast<float>();
}

// To 0 .. 1; empty where it does not vary.
Eigen::VectorXd unit_range(const Eigen::VectorXd& values) {
  if (!values.allFinite()) return {};
  const double low = values.minCoeff(), high = values.maxCoeff();
  if (!(high > low + 1e-12 * std::abs(high))) return {};
  return (values.array() - low) / (high - low);
}

void append(Eigen::MatrixXf& columns, const Eigen::VectorXf& column) {
  columns.conservativeResize(column.size(), columns.cols() + 1);
  columns.col(columns.cols() - 1) = column;
}

}  // namespace

Omnibus::Omnibus(const Problem& problem, const Eigen::MatrixXd& series,
                 const std::vector<std::string>& excluded)
    : problem_(problem), series_(series) {
  const Eigen::Index n = problem.timeline.rows();
  const Eigen::Index waves = std::clamp<Eigen::Index>(n / kRowsPerWave, 1, kMostWaves);
  Eigen::VectorXd order(n);
  for (Eigen::Index i = 0; i < n; ++i)
    order[i] = (static_cast<double>(i) + 0.5) / static_cast<double>(n);
  time_waves_.resize(n, waves);
  time_waves_.col(0).setOnes();
  for (Eigen::Index k = 1; k < waves; ++k) time_waves_.col(k) = wave(order, static_cast<int>(k));
  bands_.push_back({0, 1, "throughout"});
  for (Eigen::Index first = 1; first < waves; first = 2 * first + 1) {
    const Eigen::Index count = std::min(first + 1, waves - first);
    bands_.push_back({first, count, first < 3 ? "slowly with time" : "with time"});
  }
  add_groups(excluded);
}

void Omnibus::add_groups(const std::vector<std::string>& excluded) {
  const Eigen::Index n = problem_.timeline.rows();
  const Dataset& data = problem_.prepared.conditions();
  const auto outputs = problem_.output_symbols();
  const auto add = [&](Group group) {
    if (group.waves.cols() > 0) groups_.push_back(std::move(group));
  };
  add({"every row", Eigen::MatrixXf::Ones(n, 1), {}});
  struct Axis {
    std::string name;
    Eigen::VectorXd u;
  };
  std::vector<Axis> axes;
  std::vector<Eigen::VectorXd> temperatures, directions;
  std::vector<std::string> direction_of;
  const auto learned = [&](const std::vector<double>& values) {
    return Eigen::VectorXd(problem_.learned(Eigen::Map<const Eigen::VectorXd>(
        values.data(), static_cast<Eigen::Index>(values.size()))));
  };
  bool any_pose = false;
  for (const auto& column : data.columns)
    any_pose =
        any_pose || (is_pose_symbol(column.channel.symbol) && is_length(column.channel.unit) &&
                     unit_range(learned(column.values)).size() > 0);
  for (const auto& column : data.columns) {
    const auto& symbol = column.channel.symbol;
    if (std::ranges::find(excluded, symbol) != excluded.end()) continue;
    if (is_response(column.channel, outputs)) continue;
    Eigen::VectorXd values = learned(column.values);
    const Eigen::VectorXd u = unit_range(values);
    if (u.size() == 0) continue;
    if (is_motor_symbol(symbol)) {
      if (!any_pose) axes.push_back({symbol, u});
      Eigen::VectorXd direction = Eigen::VectorXd::Zero(n);
      for (Eigen::Index i = 1; i < n; ++i)
        direction[i] =
            std::abs(u[i] - u[i - 1]) > 1e-3 ? (u[i] > u[i - 1] ? 1 : -1) : direction[i - 1];
      directions.push_back(std::move(direction));
      direction_of.push_back(symbol);
    } else if (is_pose_symbol(symbol) && is_length(column.channel.unit)) {
      axes.push_back({symbol, u});
    } else if (is_structure_temperature(column.channel)) {
      temperatures.push_back((values.array() - values.mean()) /
                             std::sqrt((values.array() - values.mean()).square().mean()));
    } else if (!symbol.ends_with("_std") && !symbol.ends_with("_cmd")) {
      Group group{symbol, {}, {symbol}};
      for (int k = 1; k <= kConditionWaves; ++k) append(group.waves, wave(u, k));
      add(std::move(group));
    }
  }
  if (axes.size() > 3) axes.resize(3);
  for (const auto& axis : axes) {
    Group group{axis.name, {}, {axis.name}};
    for (int k = 1; k <= kAxisWaves; ++k) append(group.waves, wave(axis.u, k));
    add(std::move(group));
  }
  for (std::size_t a = 0; a < axes.size(); ++a)
    for (std::size_t b = a + 1; b < axes.size(); ++b) {
      Group group{axes[a].name + " and " + axes[b].name, {}, {axes[a].name, axes[b].name}};
      for (int k = 1; k <= kPairWaves; ++k)
        for (int l = 1; l <= kPairWaves; ++l)
          append(group.waves, wave(axes[a].u, k).cwiseProduct(wave(axes[b].u, l)));
      add(std::move(group));
    }
  if (axes.size() == 3) {
    Group group{"x, y and z", {}, {axes[0].name, axes[1].name, axes[2].name}};
    for (int k = 1; k <= kTripleWaves; ++k)
      for (int l = 1; l <= kTripleWaves; ++l)
        for (int m = 1; m <= kTripleWaves; ++m)
          append(
              group.waves,
              wave(axes[0].u, k).cwiseProduct(wave(axes[1].u, l)).cwiseProduct(wave(axes[2].u, m)));
    add(std::move(group));
  }
  if (!temperatures.empty()) {
    Eigen::MatrixXd all(n, static_cast<Eigen::Index>(temperatures.size()));
    for (std::size_t t = 0; t < temperatures.size(); ++t)
      all.col(static_cast<Eigen::Index>(t)) = temperatures[t];
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(all.transpose() * all);
    Group group{"the temperatures", {}, {}};
    for (Eigen::Index c = 0; c < std::min<Eigen::Index>(2, all.cols()); ++c) {
      const Eigen::VectorXd u = unit_range(all * eigen.eigenvectors().col(all.cols() - 1 - c));
      for (int k = 1; u.size() > 0 && k <= kConditionWaves; ++k) append(group.waves, wave(u, k));
    }
    add(std::move(group));
  }
  if (!data.dwell_s.empty())
    if (const Eigen::VectorXd u = unit_range(learned(data.dwell_s)); u.size() > 0) {
      Group group{"the dwell", {}, {}};
      for (int k = 1; k <= 2; ++k) append(group.waves, wave(u, k));
      add(std::move(group));
    }
  for (std::size_t d = 0; d < directions.size(); ++d) {
    Group group{"the direction of " + direction_of[d], {}, {}};
    const Eigen::VectorXf sign = directions[d].cast<float>();
    append(group.waves, sign);
    for (const auto& axis : axes)
      for (int k = 1; k <= 2; ++k) append(group.waves, wave(axis.u, k).cwiseProduct(sign));
    add(std::move(group));
  }
  // Fields need narrow families: their growth pays for every column.
  fields_ = groups_;
  for (const auto& axis : axes) {
    Group smooth{axis.name, {}, {axis.name}}, memory{axis.name + " and the rows before", {}, {}};
    for (int k = 1; k <= kSmoothWaves; ++k) append(smooth.waves, wave(axis.u, k));
    for (Eigen::Index lag = 1; lag <= kLags && lag < n; ++lag) {
      Eigen::VectorXd before(n);
      before << axis.u.head(lag), axis.u.head(n - lag);
      for (int k = 1; k <= kMemoryWaves; ++k)
        for (int l = 1; l <= kMemoryWaves; ++l)
          append(memory.waves, wave(axis.u, k).cwiseProduct(wave(before, l)));
    }
    fields_.push_back(std::move(smooth));
    fields_.push_back(std::move(memory));
  }
  for (std::size_t d = 0; d < directions.size(); ++d)
    fields_.push_back({"the direction of " + direction_of[d], directions[d].cast<float>(), {}});
  auto places = motor_places(problem_);
  place_of_ = std::move(places.of_block);
  place_count_ = places.places.size();
  by_place_.clear();
  for (Eigen::Index i = 0; i < n && !place_of_.empty(); ++i) by_place_.push_back(i);
  // Neighbours along the coordinates, visits of one place in time order.
  std::ranges::stable_sort(by_place_, {}, [&](Eigen::Index i) {
    return places.places[place_of_[static_cast<std::size_t>(i)]];
  });
  if (place_count_ >= 4 && 2 * place_count_ <= static_cast<std::size_t>(n))
    groups_.push_back({"the place", {}, {}});
  else
    place_count_ = 0;
}

Eigen::MatrixXf Omnibus::white(const SoftBase& base, Eigen::Index output, const NoiseShape& shape,
                               const Eigen::MatrixXd& series) const {
  (void)output;
  const WhitenedSpace space(problem_.timeline, shape, independent_base(base));
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
  const auto families = static_cast<Eigen::Index>(groups_.size()) * bands + kLags + 1;
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
  const Eigen::Index last = static_cast<Eigen::Index>(groups_.size()) * bands;
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
      if (ground.space(s).shape().tau_s <= longest &&
          ground.worse_by(s, o) < ground.worse_by(best, o))
        best = s;
    add(ground.noise(o));
    add(ground.space(best).shape());
  }
  return shapes;
}

std::optional<Omnibus::Grown> Omnibus::grown(const RandomField& field,
                                             const std::vector<Eigen::MatrixXd>& series,
                                             const std::function<bool()>& tick) const {
  std::vector<RandomField::Seen> seen;
  for (const auto& one : series) seen.push_back(field.see(one));
  Grown result{Eigen::VectorXd::Zero(series.front().cols())};
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
      for (Eigen::Index o = 0; o < growth.rows(); ++o)
        for (Eigen::Index k = 0; k < growth.cols(); ++k) {
          const double one = std::sqrt(growth(o, k));
          if (one <= result.largest[k]) continue;
          result.largest[k] = one;
          if (k == 0) result.field = g, result.band = b, result.output = o;
        }
    }
  }
  return result;
}

std::optional<OmnibusResult> Omnibus::test(const SoftBase& base, const OmnibusOptions& options) {
  const Ground ground(problem_.timeline, noise_grid(problem_.timeline), base, series_,
                      options.tick);
  if (options.tick && !options.tick()) return std::nullopt;
  const Eigen::Index outputs = series_.cols();
  const auto quadratic = static_cast<Eigen::Index>(groups_.size() * bands_.size());
  noise_.clear();
  white_sd_.clear();
  for (Eigen::Index o = 0; o < outputs; ++o) {
    noise_.push_back(ground.noise(o));
    white_sd_.push_back(ground.white_sd(o));
  }
  const Eigen::MatrixXd mixing = ground.correlation().llt().matrixL();
  std::mt19937_64 random(options.seed);
  std::vector<Eigen::MatrixXd> all(static_cast<std::size_t>(outputs));  // families x series
  std::vector<Eigen::VectorXf> own;
  const RandomField field(problem_.timeline, shapes_with_a_field(ground), base, kClip);
  Grown growths;
  OmnibusResult result;
  std::size_t family = 0;
  Eigen::Index output = 0;
  bool field_is_larger = false;
  for (const int more : {std::min(kFirstNulls, options.nulls), options.nulls - kFirstNulls}) {
    if (more <= 0) break;
    const bool with_data = result.nulls == 0;
    std::vector<Eigen::MatrixXd> series(static_cast<std::size_t>(outputs),
                                        Eigen::MatrixXd(series_.rows(), more + with_data));
    for (Eigen::Index k = 0; k < more + with_data; ++k) {
      const Eigen::MatrixXd drawn =
          with_data && k == 0 ? series_
                              : simulated_noise(problem_.timeline, noise_, mixing, random);
      for (Eigen::Index o = 0; o < outputs; ++o)
        series[static_cast<std::size_t>(o)].col(k) = drawn.col(o);
    }
    result.nulls += more;
    auto fields = grown(field, series, options.tick);
    if (!fields) return std::nullopt;
    if (with_data)
      growths = std::move(*fields);
    else
      growths.largest =
          (Eigen::VectorXd(growths.largest.size() + more) << growths.largest, fields->largest)
              .finished();
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
    mean_.clear();
    sd_.clear();
    for (Eigen::Index o = 0; o < outputs; ++o) {
      Eigen::MatrixXd z = all[static_cast<std::size_t>(o)];
      z.topRows(quadratic) = z.topRows(quadratic).array().max(0.0).pow(1.0 / 3);
      const Eigen::VectorXd mean = z.rowwise().mean();
      z.colwise() -= mean;
      const Eigen::VectorXd sd =
          (z.rowwise().squaredNorm() / static_cast<double>(count)).cwiseSqrt();
      mean_.push_back(mean);
      sd_.push_back(sd);
      for (Eigen::Index f = 0; f < z.rows(); ++f) {
        if (!(sd[f] > 1e-6 * std::abs(mean[f])) || !(sd[f] > 1e-9)) continue;
        for (Eigen::Index k = 0; k < count; ++k) {
          const double one = f < quadratic ? z(f, k) / sd[f] : std::abs(z(f, k)) / sd[f];
          if (one <= largest[k]) continue;
          largest[k] = one;
          if (k == 0) family = static_cast<std::size_t>(f), output = o;
        }
      }
    }
    // The larger of the two, each in units of its own spread over all series.
    const auto standardised = [](const Eigen::VectorXd& values) {
      const Eigen::ArrayXd about = values.array() - values.mean();
      return Eigen::ArrayXd(about / std::max(std::sqrt(about.square().mean()), 1e-300));
    };
    const Eigen::ArrayXd by_form = standardised(largest), by_field = standardised(growths.largest);
    field_is_larger = by_field[0] > by_form[0];
    const Eigen::ArrayXd both = by_form.max(by_field);
    const auto as_large = (both.tail(result.nulls) >= both[0]).count();
    result.p = static_cast<double>(1 + as_large) / static_cast<double>(count);
    const Eigen::ArrayXd nulls = both.tail(result.nulls);
    const double gumbel =  // of 99 %
        nulls.mean() + 3.14 * std::sqrt((nulls - nulls.mean()).square().mean());
    const Eigen::ArrayXd about = largest.array() - largest.mean();
    limit_ = largest.mean() + gumbel * std::sqrt(about.square().mean());
    if (as_large >= kClearlyNoise) break;
  }
  if (result.p <= options.level)
    result.where = field_is_larger
                       ? words(fields_[growths.field], bands_[growths.band], growths.output,
                               own[static_cast<std::size_t>(growths.output)])
                       : words(family, output, own[static_cast<std::size_t>(output)]);
  else
    result.smallest = smallest(base);
  return result;
}

double Omnibus::share_left(const SoftBase& with, const SoftBase& without) const {
  const auto quadratic = static_cast<Eigen::Index>(groups_.size() * bands_.size());
  double most = 0, share = 0;
  for (Eigen::Index o = 0; o < series_.cols(); ++o) {
    const auto at = static_cast<std::size_t>(o);
    const auto scaled = [&](const SoftBase& base) {
      // In units of the noise that is left with everything in, not clipped to its own size.
      const WhitenedSpace space(problem_.timeline, noise_[at], independent_base(base));
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
  const std::size_t quadratic = groups_.size() * bands_.size();
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
  const auto quadratic = static_cast<Eigen::Index>(groups_.size() * bands_.size());
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
      const WhitenedSpace space(problem_.timeline, noise_[at], independent_base(base));
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
