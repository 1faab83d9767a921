#include "server/diagnosis/search/scan.h"

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
  Eigen::ArrayXf rss;        // per series
  Eigen::ArrayXf criterion;  // per series, beyond that of a rest of 1 under the best shape
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

// Criterion of one output under each shape of noise, less what all of them share.
using ByShape = std::vector<Eigen::ArrayXXf>;  // series x cells

// As shared_shape() of ground.h, of every series and cell.
Eigen::ArrayXXf shared_total(const std::vector<ByShape>& of_output) {
  std::vector<Eigen::ArrayXXf> own;
  for (const auto& shapes : of_output) {
    own.push_back(shapes.front());
    for (const auto& shape : shapes) own.back() = own.back().min(shape);
  }
  if (own.size() == 1) return own.front();
  Eigen::ArrayXXf total =
      Eigen::ArrayXXf::Constant(own.front().rows(), own.front().cols(), INFINITY);
  for (std::size_t common = 0; common < of_output.front().size(); ++common) {
    Eigen::ArrayXXf sum = Eigen::ArrayXXf::Zero(total.rows(), total.cols());
    for (std::size_t o = 0; o < own.size(); ++o)
      sum += of_output[o][common].min(own[o] + static_cast<float>(kOwnShape));
    total = total.min(sum);
  }
  return total;
}

// counted_times() of ground.h for every series and cell, with each output's gain under the shape
// that suits it best.
Eigen::ArrayXXf counted_times_of(const std::vector<ByShape>& without,
                                 const std::vector<ByShape>& with, const Eigen::MatrixXf& alike) {
  const auto lowest = [](const ByShape& shapes) {
    Eigen::ArrayXXf own = shapes.front();
    for (const auto& shape : shapes) own = own.min(shape);
    return own;
  };
  std::vector<Eigen::ArrayXXf> sizes;
  Eigen::ArrayXXf sum = Eigen::ArrayXXf::Zero(with[0][0].rows(), with[0][0].cols());
  for (std::size_t o = 0; o < with.size(); ++o) {
    const Eigen::ArrayXXf gains =
        (lowest(without[o]).replicate(1, sum.cols()) - lowest(with[o])).max(0.0F);
    sum += gains;
    sizes.push_back(gains.sqrt());
  }
  Eigen::ArrayXXf together = sum;
  for (std::size_t a = 0; a < sizes.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      together += 2 * alike(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) * sizes[a] *
                  sizes[b];
  return (together / sum.max(1e-20F)).max(1.0F);
}

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
  const auto dof = static_cast<double>(ground.space(0, 0).dof());
  std::vector<std::vector<SeriesSide>> sides(shapes, std::vector<SeriesSide>(outputs));
  std::vector<ByShape> without(outputs);
  for (std::size_t o = 0; o < outputs; ++o) {
    const auto output = static_cast<Eigen::Index>(o);
    const auto& best = ground.space(ground.best_shape(output), output);
    // every series to length 1: floats then stay well within their range
    const Eigen::RowVectorXd inverse =
        best.left_over(series[o]).colwise().norm().cwiseMax(1e-300).cwiseInverse();
    const Eigen::MatrixXd scaled = series[o] * inverse.asDiagonal();
    for (std::size_t s = 0; s < shapes; ++s) {
      auto& side = sides[s][o];
      const auto& space = ground.space(s, output);
      side.left = space.left_over(scaled).cast<float>();
      side.rss = side.left.colwise().squaredNorm().transpose().array();
      side.criterion = static_cast<float>(dof) * side.rss.log() +
                       static_cast<float>(space.criterion(1) - best.criterion(1) +
                                          price_of(space.shape(), ground.outputs()));
      without[o].emplace_back(side.criterion);
    }
  }
  const Eigen::ArrayXf total_without = shared_total(without).col(0);
  const bool any_alike = (ground.alike().array() > 0).count() > ground.alike().rows();
  const Eigen::MatrixXf alike = ground.alike().cast<float>();
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
    std::vector<ByShape> with(outputs, ByShape(shapes));
    for (std::size_t o = 0; o < outputs; ++o)
      for (std::size_t s = 0; s < shapes; ++s)
        with[o][s] = sides[s][o].criterion.replicate(1, cells);
    std::vector<char> acts(outputs, 0);
    for (std::size_t o = 0; o < outputs; ++o)
      acts[o] =
          (bank.prior.col(static_cast<Eigen::Index>(o)).segment(first.first, width).array() > 0)
              .any();
    const bool may_not_act = std::ranges::count(acts, 1) > 1;
    Eigen::MatrixXf along, turned;
    // Whitened once for all outputs whose rows are spread alike.
    const auto of_spread = [&](std::size_t s, Eigen::Index spread) {
      Eigen::MatrixXd left =
          news_of(ground.in_spread(s, spread), raw.rowwise() - raw.colwise().mean());
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
        if (acts[o] == 0 || ground.spread_of(static_cast<Eigen::Index>(o)) != spread) continue;
        const Eigen::VectorXd widths = prior.cwiseProduct(lengths.transpose()) /
                                       ground.white_sd(static_cast<Eigen::Index>(o)).value;
        const auto& side = sides[s][o];
        along.noalias() = side.left.transpose() * basis;  // series x columns
        for (Eigen::Index c = 0, j = 0; c < cells; ++c) {
          const Eigen::Index k = bank.cells[slice.first_cell + static_cast<std::size_t>(c)].count;
          // As Ground::gain(): the mean over the prior's shares, and over "does not act".
          std::array<Eigen::ArrayXf, kPriorShares.size()> two_ln;
          Eigen::ArrayXf top = Eigen::ArrayXf::Constant(count, may_not_act ? 0.0F : -1e30F);
          for (std::size_t w = 0; w < kPriorShares.size(); ++w) {
            const Integrated one = integrated(grams[static_cast<std::size_t>(c)],
                                              kPriorShares[w] * widths.segment(j, k));
            turned.noalias() = along.middleCols(j, k) * one.turn;
            two_ln[w] =
                -static_cast<float>(dof) *
                    (1 - turned.rowwise().squaredNorm().array() / side.rss).max(1e-6F).log() -
                one.log_determinant;
            top = top.max(two_ln[w]);
          }
          Eigen::ArrayXf sum = Eigen::ArrayXf::Zero(count);
          if (may_not_act) sum = (-top / 2).exp();
          for (const auto& one : two_ln) sum += ((one - top) / 2).exp();
          const auto terms = static_cast<float>(two_ln.size() + (may_not_act ? 1 : 0));
          with[o][s].col(c) -= top + 2 * (sum / terms).log();
          j += k;
        }
      }
    };
    for (std::size_t s = 0; s < shapes; ++s)
      for (Eigen::Index spread = 0; spread < ground.spreads(); ++spread) of_spread(s, spread);
    const Eigen::ArrayXXf total_with = shared_total(with);
    Eigen::ArrayXXf gains = total_without.replicate(1, cells) - total_with;
    if (any_alike) gains /= counted_times_of(without, with, alike);
    std::vector<Part> best(static_cast<std::size_t>(count));
    for (Eigen::Index c = 0; c < cells; ++c) {
      const auto gain = gains.col(c);
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
