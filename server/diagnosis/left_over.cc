#include "server/diagnosis/left_over.h"

namespace driftwise::diagnosis {
namespace {

constexpr double kHalf = 0.5;        // of what a finding explains
constexpr double kSuperfluous = 10;  // 2 ln L: what a finding adds to the free shape

}  // namespace

Remainder::Remainder(const Problem& problem, const Eigen::MatrixXd& series,
                     const std::vector<std::string>& excluded, SearchOptions options)
    : problem_(problem),
      shapes_(free_shapes(problem, excluded)),
      search_(problem.timeline, series, shapes_.bank, std::move(options)) {}

Result<std::optional<LeftOver>> Remainder::look(const Extension& extension) {
  if (shapes_.variables.empty()) return std::optional<LeftOver>{};
  last_ = search_.look(extension.learned(), std::vector<char>(shapes_.variables.size(), 1));
  if (!last_) return fail(ErrorCode::cancelled, "CANCELLED", "the diagnosis was cancelled");
  if (!last_->first) return std::optional<LeftOver>{};
  return std::optional<LeftOver>{{shapes_.variables[*last_->first], last_->p_adjusted}};
}

std::optional<std::size_t> Remainder::nearest_name(const Extension& extension) const {
  if (!last_ || !last_->first) return std::nullopt;
  const auto& cell = shapes_.bank.cells[shapes_.bank.entries[*last_->first].first];
  const Eigen::MatrixXd shape = shapes_.bank.columns.middleCols(cell.first, cell.count);
  const double left = last_->causes[*last_->first].gain;
  const std::vector<char> on(problem_.outputs.size(), 1);
  for (std::size_t i = 0; i < extension.named().size(); ++i) {
    const Ground without = extension.ground(i, last_->shapes);
    Eigen::MatrixXd both(shape.rows(), shape.cols() + extension.named()[i].learned.cols());
    both << shape, extension.named()[i].learned;
    const double by_shape = without.gain(shape, on).gain;
    const double by_both = without.gain(both, on).gain;
    const double by_finding = without.gain(extension.named()[i].learned, on).gain;
    if (by_both - by_shape < kSuperfluous && left > kHalf * by_finding) return i;
  }
  return std::nullopt;
}

}  // namespace driftwise::diagnosis
