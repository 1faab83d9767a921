#include "server/diagnosis/scan.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

constexpr Eigen::Index kSlice = 96;  // columns at a time: they stay in the cache
constexpr std::size_t kSlicesPerTick = 2;

struct Slice {
  std::size_t entry = 0, first_cell = 0, cells = 0;  // cells of one cause, within the bank
};

struct SeriesSide {  // one output under one shape of noise
  Eigen::MatrixXf left;
  Eigen::ArrayXf rss;  // per series
  double weight = 1;   // exp of the shape's determinants over the degrees of freedom
};

std::vector<Slice> slices_of(const Bank& bank, const std::vector<char>& allowed) {
  std::vector<Slice> slices;
  for (std::size_t e = 0; e < bank.entries.size(); ++e) {
    if (allowed[e] == 0) continue;
    const auto& entry = bank.entries[e];
    for (std::size_t c = entry.first; c < entry.first + entry.count;) {
      Slice slice{e, c, 0};
      Eigen::Index columns = 0;
      while (c < entry.first + entry.count &&
             (slice.cells == 0 || columns + bank.cells[c].count <= kSlice)) {
        columns += bank.cells[c].count;
        ++slice.cells;
        ++c;
      }
      slices.push_back(slice);
    }
  }
  return slices;
}

// What turns products with a cell's columns into the square root of what its sum of squares loses
// when its amplitudes are integrated out: of one cell on one output.
struct Integrated {
  Eigen::MatrixXf turn;  // c x c
  float log_determinant = 0;
};

// gram: of the cell's columns. width: prior over noise.
Integrated integrated(const Eigen::MatrixXd& gram, const Eigen::VectorXd& width) {
  Eigen::MatrixXd g = width.asDiagonal() * gram * width.asDiagonal();
  g.diagonal().array() += 1;
  const Eigen::LLT<Eigen::MatrixXd> cholesky(g);
  Integrated result;
  double log_determinant = 0;
  for (Eigen::Index k = 0; k < g.cols(); ++k)
    log_determinant += 2 * std::log(cholesky.matrixL()(k, k));
  result.log_determinant = static_cast<float>(log_determinant);
  const Eigen::MatrixXd scaled = width.asDiagonal();
  result.turn = cholesky.matrixL().solve(scaled).transpose().cast<float>();
  return result;
}

// 2 ln of the weighted sum of exp(gain / 2), one cell after the other.
struct Average {
  float top = -1e30F, sum = 0;
  void add(float two_ln) {
    if (two_ln > top) {
      sum = sum * std::exp((top - two_ln) / 2) + 1;
      top = two_ln;
    } else if (two_ln > top - 60) {
      sum += std::exp((two_ln - top) / 2);
    }
  }
  double value() const { return sum > 0 ? top + 2 * std::log(sum) : -1e300; }
};

using Rests = std::array<Eigen::ArrayXXf, kPriorShares.size()>;  // series x cells, per share

struct Part {  // of a cause's cells, for one series
  Average average;
  float top = -1e30F, gain = -1e30F;
  std::size_t cell = 0;
  void join(const Part& other) {
    if (other.average.sum > 0) {
      const float level = std::max(average.top, other.average.top);
      average.sum = average.sum * std::exp((average.top - level) / 2) +
                    other.average.sum * std::exp((other.average.top - level) / 2);
      average.top = level;
    }
    if (other.top > top) top = other.top, gain = other.gain, cell = other.cell;
  }
};

}  // namespace

std::vector<std::vector<Best>> scan(const Bank& bank, const Ground& ground,
                                    const std::vector<Eigen::MatrixXd>& series,
                                    const std::vector<char>& allowed, const ScanOptions& options) {
  const auto outputs = series.size();
  const Eigen::Index count = series.front().cols();
  const std::size_t shapes = ground.shape_count();
  const auto dof = static_cast<double>(ground.space(0).dof());
  std::vector<std::vector<SeriesSide>> sides(shapes, std::vector<SeriesSide>(outputs));
  std::vector<Eigen::ArrayXf> lowest(outputs, Eigen::ArrayXf::Constant(count, INFINITY));
  for (std::size_t o = 0; o < outputs; ++o) {
    const auto& best = ground.space(ground.best_shape(static_cast<Eigen::Index>(o)));
    // every series to length 1: floats then stay well within their range
    const Eigen::RowVectorXd inverse =
        best.left_over(series[o]).colwise().norm().cwiseMax(1e-300).cwiseInverse();
    const Eigen::MatrixXd scaled = series[o] * inverse.asDiagonal();
    for (std::size_t s = 0; s < shapes; ++s) {
      auto& side = sides[s][o];
      side.weight = std::exp((ground.space(s).criterion(1) - best.criterion(1)) / dof);
      side.left = ground.space(s).left_over(scaled).cast<float>();
      side.rss = side.left.colwise().squaredNorm().transpose().array();
      lowest[o] = lowest[o].min(side.rss * static_cast<float>(side.weight));
    }
  }
  const auto slices = slices_of(bank, allowed);
  std::vector<std::vector<Part>> of_slice(slices.size());
  const auto job = [&](std::size_t at) {
    const Slice& slice = slices[at];
    const auto& entry = bank.entries[slice.entry];
    const auto& first = bank.cells[slice.first_cell];
    const auto& last = bank.cells[slice.first_cell + slice.cells - 1];
    const Eigen::Index width = last.first + last.count - first.first;
    const auto cells = static_cast<Eigen::Index>(slice.cells);
    const Eigen::MatrixXd raw = bank.columns.middleCols(first.first, width);
    std::vector<Rests> with(outputs);
    for (auto& rests : with) rests.fill(Eigen::ArrayXXf::Constant(count, cells, INFINITY));
    Eigen::MatrixXf along, turned;
    for (std::size_t s = 0; s < shapes; ++s) {
      Eigen::MatrixXd left = news_of(ground.space(s), raw.rowwise() - raw.colwise().mean());
      const Eigen::RowVectorXd lengths = left.colwise().norm().cwiseMax(1e-300);
      left = left * lengths.cwiseInverse().asDiagonal();
      const Eigen::MatrixXf basis = left.cast<float>();
      std::vector<Eigen::MatrixXd> grams;
      for (Eigen::Index c = 0, j = 0; c < cells; ++c) {
        const Eigen::Index k = bank.cells[slice.first_cell + static_cast<std::size_t>(c)].count;
        const auto own = left.middleCols(j, k);
        grams.emplace_back(own.transpose() * own);
        j += k;
      }
      for (std::size_t o = 0; o < outputs; ++o) {
        const auto prior = bank.prior.col(static_cast<Eigen::Index>(o)).segment(first.first, width);
        if ((prior.array() <= 0).all()) continue;
        const Eigen::VectorXd widths =
            prior.cwiseProduct(lengths.transpose()) / ground.white_sd(static_cast<Eigen::Index>(o));
        const auto& side = sides[s][o];
        along.noalias() = side.left.transpose() * basis;  // series x columns
        for (Eigen::Index c = 0, j = 0; c < cells; ++c) {
          const Eigen::Index k = bank.cells[slice.first_cell + static_cast<std::size_t>(c)].count;
          for (std::size_t w = 0; w < kPriorShares.size(); ++w) {
            const Integrated one = integrated(grams[static_cast<std::size_t>(c)],
                                              kPriorShares[w] * widths.segment(j, k));
            turned.noalias() = along.middleCols(j, k) * one.turn;
            const Eigen::ArrayXf rest =
                (side.rss - turned.rowwise().squaredNorm().array()).max(1e-6f * side.rss) *
                static_cast<float>(side.weight) *
                std::exp(one.log_determinant / static_cast<float>(dof));
            with[o][w].col(c) = with[o][w].col(c).min(rest);
          }
          j += k;
        }
      }
    }
    std::vector<Part> best(static_cast<std::size_t>(count));
    for (Eigen::Index c = 0; c < cells; ++c) {
      Eigen::ArrayXf gain = Eigen::ArrayXf::Zero(count);
      std::size_t acts_on = 0;
      for (const auto& rests : with) acts_on += std::isfinite(rests[0](0, c)) ? 1 : 0;
      for (std::size_t o = 0; o < outputs; ++o) {
        if (!std::isfinite(with[o][0](0, c))) continue;
        // As Ground::gain(): the mean over the prior's shares, and over "does not act".
        std::array<Eigen::ArrayXf, kPriorShares.size()> two_ln;
        Eigen::ArrayXf top = Eigen::ArrayXf::Constant(count, acts_on > 1 ? 0.0F : -1e30F);
        for (std::size_t w = 0; w < two_ln.size(); ++w) {
          two_ln[w] = static_cast<float>(dof) * (lowest[o] / with[o][w].col(c)).log();
          top = top.max(two_ln[w]);
        }
        Eigen::ArrayXf sum = Eigen::ArrayXf::Zero(count);
        if (acts_on > 1) sum = (-top / 2).exp();
        for (const auto& one : two_ln) sum += ((one - top) / 2).exp();
        const auto terms = static_cast<float>(two_ln.size() + (acts_on > 1 ? 1 : 0));
        gain += top + 2 * (sum / terms).log();
      }
      const std::size_t cell = slice.first_cell + static_cast<std::size_t>(c);
      const auto weight = static_cast<float>(2 * bank.ln_weight[cell]);
      for (Eigen::Index k = 0; k < count; ++k) {
        auto& one = best[static_cast<std::size_t>(k)];
        one.average.add(gain[k] + weight);
        if (gain[k] + weight > one.top) {
          one.top = gain[k] + weight;
          one.gain = gain[k];
          one.cell = cell - entry.first;
        }
      }
    }
    of_slice[at] = std::move(best);
  };
  for (std::size_t begin = 0; begin < slices.size(); begin += kSlicesPerTick) {
    if (options.tick && !options.tick()) return {};
    calibration::run_on(options.executor, std::min(kSlicesPerTick, slices.size() - begin),
                        [&](std::size_t i) { job(begin + i); });
  }
  std::vector<std::vector<Part>> of_entry(bank.entries.size(),
                                          std::vector<Part>(static_cast<std::size_t>(count)));
  for (std::size_t i = 0; i < slices.size(); ++i)
    for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k)
      of_entry[slices[i].entry][k].join(of_slice[i][k]);
  std::vector<std::vector<Best>> best(bank.entries.size());
  for (std::size_t e = 0; e < best.size(); ++e)
    for (const auto& part : of_entry[e])
      best[e].push_back(allowed[e] == 0 ? Best{}
                                        : Best{part.average.value(), part.gain, part.cell});
  return best;
}

}  // namespace driftwise::diagnosis
