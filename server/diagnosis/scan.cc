#include "server/diagnosis/scan.h"

#include <algorithm>
#include <cmath>

#include "server/diagnosis/chance.h"

namespace driftwise::diagnosis {
namespace {

constexpr Eigen::Index kSlice = 96;  // columns at a time: they stay in the cache
constexpr std::size_t kSlicesPerTick = 2;
constexpr double kThere = 1e-4;  // as in ground.cc

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

// Cell by cell orthonormal; columns that are already there become 0.
void orthonormalise(const Bank& bank, const Slice& slice, const Eigen::RowVectorXd& lengths,
                    Eigen::MatrixXd& left) {
  Eigen::Index j = 0;
  for (std::size_t c = 0; c < slice.cells; ++c) {
    const Eigen::Index first = j;
    for (; j < first + bank.cells[slice.first_cell + c].count; ++j) {
      for (int pass = 0; pass < 2; ++pass)
        for (Eigen::Index k = first; k < j; ++k)
          left.col(j) -= left.col(k).dot(left.col(j)) * left.col(k);
      const double length = left.col(j).norm();
      if (length > kThere * lengths[j] && std::isfinite(length))
        left.col(j) /= length;
      else
        left.col(j).setZero();
    }
  }
}

}  // namespace

int dof_of(const Bank& bank, const Bank::Entry& entry, std::size_t cell) {
  return static_cast<int>(bank.cells[entry.first + cell].count *
                          std::ranges::count_if(entry.on, [](char on) { return on != 0; }));
}

int smallest_dof(const Bank& bank, const Bank::Entry& entry) {
  int smallest = dof_of(bank, entry, 0);
  for (std::size_t c = 1; c < entry.count; ++c)
    smallest = std::min(smallest, dof_of(bank, entry, c));
  return smallest;
}

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
  std::vector<std::vector<Best>> of_slice(slices.size());
  const auto job = [&](std::size_t at) {
    const Slice& slice = slices[at];
    const auto& entry = bank.entries[slice.entry];
    const auto& first = bank.cells[slice.first_cell];
    const auto& last = bank.cells[slice.first_cell + slice.cells - 1];
    const Eigen::Index width = last.first + last.count - first.first;
    const auto cells = static_cast<Eigen::Index>(slice.cells);
    const Eigen::MatrixXd raw = bank.columns.middleCols(first.first, width);
    std::vector<Eigen::ArrayXXf> with(outputs, Eigen::ArrayXXf::Constant(count, cells, INFINITY));
    Eigen::MatrixXf along;
    for (std::size_t s = 0; s < shapes; ++s) {
      Eigen::MatrixXd left = raw.rowwise() - raw.colwise().mean();
      ground.space(s).whiten(left);
      const Eigen::RowVectorXd lengths = left.colwise().norm();
      ground.space(s).project(left);
      orthonormalise(bank, slice, lengths, left);
      const Eigen::MatrixXf basis = left.cast<float>();
      for (std::size_t o = 0; o < outputs; ++o) {
        if (entry.on[o] == 0) continue;
        const auto& side = sides[s][o];
        along.noalias() = side.left.transpose() * basis;  // series x columns
        Eigen::Index j = 0;
        for (Eigen::Index c = 0; c < cells; ++c) {
          Eigen::ArrayXf rest = side.rss;
          for (Eigen::Index k = 0;
               k < bank.cells[slice.first_cell + static_cast<std::size_t>(c)].count; ++k, ++j)
            rest -= along.col(j).array().square();
          with[o].col(c) =
              with[o].col(c).min(rest.max(1e-6f * side.rss) * static_cast<float>(side.weight));
        }
      }
    }
    const int cheapest = smallest_dof(bank, entry);
    std::vector<Best> best(static_cast<std::size_t>(count));
    for (Eigen::Index c = 0; c < cells; ++c) {
      Eigen::ArrayXf gain = Eigen::ArrayXf::Zero(count);
      for (std::size_t o = 0; o < outputs; ++o)
        if (entry.on[o] != 0) gain += static_cast<float>(dof) * (lowest[o] / with[o].col(c)).log();
      const std::size_t cell = slice.first_cell + static_cast<std::size_t>(c) - entry.first;
      const int here = dof_of(bank, entry, cell);
      const double price = here == cheapest ? 0 : price_of(here) - price_of(cheapest);
      for (Eigen::Index k = 0; k < count; ++k) {
        auto& one = best[static_cast<std::size_t>(k)];
        const double score = static_cast<double>(gain[k]) - price;
        if (score > one.score) one = {static_cast<double>(gain[k]), score, cell};
      }
    }
    of_slice[at] = std::move(best);
  };
  for (std::size_t begin = 0; begin < slices.size(); begin += kSlicesPerTick) {
    if (options.tick && !options.tick()) return {};
    calibration::run_on(options.executor, std::min(kSlicesPerTick, slices.size() - begin),
                        [&](std::size_t i) { job(begin + i); });
  }
  std::vector<std::vector<Best>> best(bank.entries.size(),
                                      std::vector<Best>(static_cast<std::size_t>(count)));
  for (std::size_t i = 0; i < slices.size(); ++i)
    for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k)
      if (of_slice[i][k].score > best[slices[i].entry][k].score)
        best[slices[i].entry][k] = of_slice[i][k];
  return best;
}

}  // namespace driftwise::diagnosis
