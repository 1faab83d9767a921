#include "server/diagnosis/search/entry_gate.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "server/diagnosis/rows/motor_places.h"
#include "server/diagnosis/rows/place_groups.h"

namespace driftwise::diagnosis {
namespace {

constexpr Eigen::Index kTimeFolds = 5, kShortBlocks = 60, kFewestGapRows = 2;
constexpr double kMostGap = 0.04;  // of the rows, on either side
constexpr std::size_t kPlaceFolds = 6, kFewestPlaces = 6;
constexpr double kRidge = 1e-9;         // of a column's own square
constexpr double kReach = 40;           // 2 ln: what is further off the best has no weight
constexpr std::size_t kMostCells = 40;  // that a prediction is averaged over

// Sums over rows of everything that a fit and a choice of the parameter need.
struct Sums {
  Eigen::MatrixXd bb, bz;
  Eigen::VectorXd by, zy;
  std::vector<Eigen::MatrixXd> zz;  // per cell

  void operator-=(const Sums& other) {
    bb -= other.bb, bz -= other.bz, by -= other.by, zy -= other.zy;
    for (std::size_t c = 0; c < zz.size(); ++c) zz[c] -= other.zz[c];
  }
};

// One output, whitened, in units of its noise.
struct Side {
  Eigen::MatrixXd base, cells;
  Eigen::VectorXd y, precision;  // of the base
  Eigen::VectorXd width;         // prior sd of each cell column over the noise
  Sums all;
};

Sums sums_of(const Side& side, const std::vector<Bank::Cell>& cells,
             const std::vector<Eigen::Index>* rows) {
  const auto of = [&](const Eigen::MatrixXd& m) {
    return rows == nullptr ? m : Eigen::MatrixXd(m(*rows, Eigen::all));
  };
  const Eigen::MatrixXd b = of(side.base), z = of(side.cells);
  const Eigen::VectorXd y = of(side.y);
  Sums sums{b.transpose() * b, b.transpose() * z, b.transpose() * y, z.transpose() * y, {}};
  for (const auto& cell : cells) {
    const auto own = z.middleCols(cell.first, cell.count);
    sums.zz.emplace_back(own.transpose() * own);
  }
  return sums;
}

// Twice the log of the predictive density of rows out, up to what both models share.
double predictive(const Eigen::MatrixXd& a, const Eigen::VectorXd& along, const Eigen::MatrixXd& x,
                  const Eigen::VectorXd& y) {
  const Eigen::LLT<Eigen::MatrixXd> fitted(a);
  const Eigen::VectorXd e = y - x * fitted.solve(along);
  const Eigen::MatrixXd m = a + x.transpose() * x;
  const Eigen::LLT<Eigen::MatrixXd> with(m);
  double log_ratio = 0;
  for (Eigen::Index k = 0; k < a.cols(); ++k)
    log_ratio += 2 * std::log(with.matrixL()(k, k) / fitted.matrixL()(k, k));
  const Eigen::VectorXd xe = x.transpose() * e;
  return -(e.squaredNorm() - xe.dot(with.solve(xe))) - log_ratio;
}

// Cells that share what the learned rows say of the parameter: those within reach of the best.
std::vector<std::size_t> likeliest(const Eigen::VectorXd& evidence) {
  std::vector<std::size_t> cells;
  const double best = evidence.maxCoeff();
  for (Eigen::Index c = 0; c < evidence.size(); ++c)
    if (evidence[c] >= best - kReach) cells.push_back(static_cast<std::size_t>(c));
  std::ranges::stable_sort(cells, std::ranges::greater{},
                           [&](std::size_t c) { return evidence[static_cast<Eigen::Index>(c)]; });
  if (cells.size() > kMostCells) cells.resize(kMostCells);
  return cells;
}

// 2 ln of a sum of densities that are given as 2 ln.
double two_ln_sum(const std::vector<double>& two_ln) {
  const double most = std::ranges::max(two_ln);
  double sum = 0;
  for (const double one : two_ln) sum += std::exp((one - most) / 2);
  return most + 2 * std::log(sum);
}

}  // namespace

EntryGate::EntryGate(const Problem& problem, const Eigen::MatrixXd& series, const Bank& bank)
    : problem_(problem), series_(series), bank_(bank) {
  const auto [places, place_of] = motor_places(problem);
  if (place_of.empty() || places.size() < kFewestPlaces) return;
  for (const auto& group : neighbouring_groups(places, kPlaceFolds)) {
    std::vector<char> in(places.size(), 0);
    for (const std::size_t place : group) in[place] = 1;
    Fold fold;
    for (std::size_t row = 0; row < place_of.size(); ++row)
      if (in[place_of[row]] != 0) fold.out.push_back(static_cast<Eigen::Index>(row));
    place_folds_.push_back(std::move(fold));
  }
}

std::vector<EntryGate::Fold> EntryGate::time_folds(double gap_s) const {
  const auto& time_s = problem_.timeline.time_s;
  const Eigen::Index n = time_s.size();
  std::vector<Fold> folds;
  const auto most = static_cast<Eigen::Index>(kMostGap * static_cast<double>(n));
  for (Eigen::Index f = 0; f < kTimeFolds; ++f) {
    Fold fold;
    const Eigen::Index begin = f * n / kTimeFolds, end = (f + 1) * n / kTimeFolds;
    for (Eigen::Index i = begin; i < end; ++i) fold.out.push_back(i);
    for (Eigen::Index i = begin - 1, k = 0; i >= 0 && k < most; --i, ++k)
      if (k < kFewestGapRows || time_s[begin] - time_s[i] < gap_s) fold.idle.push_back(i);
    for (Eigen::Index i = end, k = 0; i < n && k < most; ++i, ++k)
      if (k < kFewestGapRows || time_s[i] - time_s[end - 1] < gap_s) fold.idle.push_back(i);
    folds.push_back(std::move(fold));
  }
  return folds;
}

std::vector<EntryGate::Fold> EntryGate::alternating_folds() const {
  const Eigen::Index n = problem_.timeline.rows();
  std::vector<Fold> folds(2);
  for (Eigen::Index i = 0; i < n; ++i)
    folds[static_cast<std::size_t>(i * kShortBlocks / n % 2)].out.push_back(i);
  return folds;
}

double EntryGate::score(const std::vector<Fold>& folds, const SoftBase& base,
                        const std::vector<NoiseShape>& noise, const std::vector<double>& sd,
                        std::size_t entry) const {
  const auto& own = bank_.entries[entry];
  const Eigen::Index first = bank_.cells[own.first].first;
  const auto& last = bank_.cells[own.first + own.count - 1];
  const Eigen::Index width = last.first + last.count - first;
  std::vector<Bank::Cell> cells;
  for (std::size_t c = 0; c < own.count; ++c)
    cells.push_back({bank_.cells[own.first + c].first - first, bank_.cells[own.first + c].count});
  const SoftBase independent = independent_base(base);
  const Eigen::Index free = independent.free_count();
  std::vector<Side> sides;
  const bool may_not_act =
      (bank_.prior.middleRows(first, width).array() > 0).colwise().any().count() > 1;
  for (Eigen::Index o = 0; o < series_.cols(); ++o) {
    const auto at = static_cast<std::size_t>(o);
    const Eigen::VectorXd prior = bank_.prior.col(o).segment(first, width);
    if ((prior.array() <= 0).all()) continue;
    const Whitener whitener(problem_.timeline, noise[at], o);
    Side side;
    side.base = independent.columns;
    whitener.apply(side.base);
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(side.base.leftCols(free));
    side.base.leftCols(free) =
        qr.householderQ() * Eigen::MatrixXd::Identity(side.base.rows(), free);
    side.precision = independent.precision;
    // Found causes in units of their own: a play's column in mm is some 1e-6 large.
    for (Eigen::Index k = free; k < side.base.cols(); ++k) {
      const double length = side.base.col(k).norm();
      if (length == 0) continue;
      side.base.col(k) /= length;
      side.precision[k] /= length * length;
    }
    const Eigen::MatrixXd raw = bank_.columns.middleCols(first, width);
    side.cells = raw.rowwise() - raw.colwise().mean();
    whitener.apply(side.cells);
    // Beyond the free columns of all rows: the same models, better numbers.
    side.cells -=
        side.base.leftCols(free) * (side.base.leftCols(free).transpose() * side.cells).eval();
    side.cells = side.cells * (prior / sd[at]).asDiagonal();
    Eigen::MatrixXd y = series_.col(o);
    whitener.apply(y);
    side.y =
        (y - side.base.leftCols(free) * (side.base.leftCols(free).transpose() * y).eval()) / sd[at];
    side.all = sums_of(side, cells, nullptr);
    sides.push_back(std::move(side));
  }
  double total = 0;
  for (const Fold& fold : folds) {
    if (fold.out.empty()) continue;
    std::vector<Eigen::Index> not_learned = fold.out;
    not_learned.insert(not_learned.end(), fold.idle.begin(), fold.idle.end());
    std::vector<Sums> learned;
    std::vector<Eigen::LLT<Eigen::MatrixXd>> fits;
    std::vector<Eigen::MatrixXd> a0;
    std::vector<std::vector<double>> shares;  // per side, per cell: what its rows say
    Eigen::VectorXd evidence = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(cells.size()));
    for (const Side& side : sides) {
      Sums sums = side.all;
      sums -= sums_of(side, cells, &not_learned);
      Eigen::MatrixXd a = sums.bb;
      a.diagonal() += side.precision;
      a.diagonal().array() += kRidge;
      fits.emplace_back(a);
      const Eigen::MatrixXd turned = fits.back().matrixL().solve(sums.bz);
      const Eigen::VectorXd left = fits.back().matrixL().solve(sums.by);
      const Eigen::VectorXd along = sums.zy - turned.transpose() * left;
      auto& of_cell = shares.emplace_back();
      for (std::size_t c = 0; c < cells.size(); ++c) {
        const auto own_turned = turned.middleCols(cells[c].first, cells[c].count);
        const Eigen::MatrixXd gram = sums.zz[c] - own_turned.transpose() * own_turned;
        const Eigen::VectorXd own_along = along.segment(cells[c].first, cells[c].count);
        ByShare two_ln{};
        for (std::size_t w = 0; w < two_ln.size(); ++w) {
          Eigen::MatrixXd g = kPriorShares[w] * kPriorShares[w] * gram;
          g.diagonal().array() += 1;
          const Eigen::LLT<Eigen::MatrixXd> cholesky(g);
          two_ln[w] = cholesky.matrixL().solve(kPriorShares[w] * own_along).squaredNorm();
          for (Eigen::Index k = 0; k < g.cols(); ++k)
            two_ln[w] -= 2 * std::log(std::max(cholesky.matrixL()(k, k), 1e-12));
        }
        evidence[static_cast<Eigen::Index>(c)] += averaged(two_ln, may_not_act);
        of_cell.push_back(likeliest_share(two_ln, may_not_act));
      }
      a0.push_back(std::move(a));
      learned.push_back(std::move(sums));
    }
    for (std::size_t c = 0; c < cells.size(); ++c)
      evidence[static_cast<Eigen::Index>(c)] += 2 * bank_.ln_weight[own.first + c];
    // Averaged over the parameter as the learned rows leave it: instants in between two of them
    // are equally likely, and one of them only predicts what lies there.
    std::vector<double> alone;  // per side: of the rows out, without the cause
    for (std::size_t s = 0; s < sides.size(); ++s)
      alone.push_back(predictive(a0[s], learned[s].by, sides[s].base(fold.out, Eigen::all),
                                 sides[s].y(fold.out)));
    std::vector<double> before, after;
    for (const std::size_t c : likeliest(evidence)) {
      const auto& cell = cells[c];
      double growth = 0;
      for (std::size_t s = 0; s < sides.size(); ++s) {
        const Side& side = sides[s];
        const double share = shares[s][c];
        if (share == 0) continue;
        const Eigen::Index p = a0[s].cols(), k = cell.count;
        Eigen::MatrixXd a(p + k, p + k);
        Eigen::MatrixXd x(static_cast<Eigen::Index>(fold.out.size()), p + k);
        a.topLeftCorner(p, p) = a0[s];
        a.topRightCorner(p, k) = share * learned[s].bz.middleCols(cell.first, k);
        a.bottomLeftCorner(k, p) = a.topRightCorner(p, k).transpose();
        a.bottomRightCorner(k, k) = share * share * learned[s].zz[c];
        a.bottomRightCorner(k, k).diagonal().array() += 1;
        x << side.base(fold.out, Eigen::all),
            share * side.cells(fold.out, Eigen::seqN(cell.first, k));
        Eigen::VectorXd along(p + k);
        along << learned[s].by, share * learned[s].zy.segment(cell.first, k);
        growth += predictive(a, along, x, side.y(fold.out)) - alone[s];
      }
      before.push_back(evidence[static_cast<Eigen::Index>(c)]);
      after.push_back(before.back() + growth);
    }
    total += two_ln_sum(after) - two_ln_sum(before);
  }
  return total;
}

GateScore EntryGate::judge(const SoftBase& base, const std::vector<NoiseShape>& noise,
                           const std::vector<double>& sd, const Cause& cause,
                           std::size_t entry) const {
  GateScore result;
  if (cause.scale == ParameterScale::instant) {
    result.by_time = score(alternating_folds(), base, noise, sd, entry);
    return result;
  }
  double gap_s = 0;
  for (const auto& shape : noise) gap_s = std::max(gap_s, shape.slow_ratio > 0 ? shape.tau_s : 0);
  result.by_time = score(time_folds(gap_s), base, noise, sd, entry);
  if (!place_folds_.empty()) result.by_places = score(place_folds_, base, noise, sd, entry);
  return result;
}

}  // namespace driftwise::diagnosis
