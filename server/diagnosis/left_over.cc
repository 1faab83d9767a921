#include "server/diagnosis/left_over.h"

#include <algorithm>

namespace driftwise::diagnosis {
namespace {

constexpr double kHalf = 0.5;        // of what a finding explains
constexpr double kSuperfluous = 10;  // 2 ln L: what a finding adds to the free shape

Problem with_all_rows(const Problem& problem, std::size_t longest) {
  Problem whole = problem;
  whole.learn.insert(whole.learn.end(), whole.judge.begin(), whole.judge.end());
  whole.judge.clear();
  std::ranges::sort(whole.learn);
  whole.lay_blocks(longest);
  const auto& known = problem.timeline;
  if (known.sd.size() == 0) return whole;
  whole.timeline.sd.resize(whole.timeline.rows());
  for (Eigen::Index i = 0, at = 0; i < whole.timeline.rows(); ++i) {
    while (at + 1 < known.rows() && known.time_s[at + 1] <= whole.timeline.time_s[i]) ++at;
    whole.timeline.sd[i] = known.sd[at];
  }
  return whole;
}

Eigen::MatrixXd series_of(const Problem& problem) {
  Eigen::MatrixXd series(problem.timeline.rows(),
                         static_cast<Eigen::Index>(problem.outputs.size()));
  for (std::size_t o = 0; o < problem.outputs.size(); ++o)
    series.col(static_cast<Eigen::Index>(o)) = problem.learned(problem.outputs[o].measured);
  return series;
}

}  // namespace

Remainder::Remainder(const Problem& problem, std::size_t longest,
                     const std::vector<std::string>& excluded, SearchOptions options)
    : whole_(with_all_rows(problem, longest)),
      series_(series_of(whole_)),
      shapes_(free_shapes(whole_, excluded)),
      search_(whole_.timeline, series_, shapes_.bank, std::move(options)) {}

Result<std::optional<LeftOver>> Remainder::look(const Extension& extension) {
  if (shapes_.variables.empty()) return std::optional<LeftOver>{};
  last_ =
      search_.look(whole_.learned(extension.all()), std::vector<char>(shapes_.variables.size(), 1));
  if (!last_) return fail(ErrorCode::cancelled, "CANCELLED", "the diagnosis was cancelled");
  if (!last_->first) return std::optional<LeftOver>{};
  return std::optional<LeftOver>{{shapes_.variables[*last_->first], last_->p_adjusted}};
}

std::optional<std::size_t> Remainder::nearest_name(const Extension& extension) const {
  if (!last_ || !last_->first) return std::nullopt;
  const auto& cell = shapes_.bank.cells[shapes_.bank.entries[*last_->first].first];
  const Eigen::MatrixXd shape = shapes_.bank.columns.middleCols(cell.first, cell.count);
  const double left = last_->causes[*last_->first].gain;
  const std::vector<char> on(whole_.outputs.size(), 1);
  for (std::size_t i = 0; i < extension.named().size(); ++i) {
    const Ground without(whole_.timeline, last_->shapes, whole_.learned(extension.all(i)), series_);
    const Eigen::MatrixXd own = whole_.learned(extension.named()[i].all);
    Eigen::MatrixXd both(shape.rows(), shape.cols() + own.cols());
    both << shape, own;
    const double by_shape = without.gain(shape, on).gain;
    const double by_both = without.gain(both, on).gain;
    const double by_finding = without.gain(own, on).gain;
    if (by_both - by_shape < kSuperfluous && left > kHalf * by_finding) return i;
  }
  return std::nullopt;
}

}  // namespace driftwise::diagnosis
