#include "server/calibration/held_out_figure.h"

#include <cmath>

#include "server/calibration/tail.h"
#include "server/core/units.h"

namespace driftwise::calibration {

HeldOut held_out_figure(const std::vector<FoldSquares>& folds) {
  double squares = 0, rows = 0;
  for (const auto& fold : folds) {
    squares += fold.squares;
    rows += fold.rows;
  }
  if (!(squares > 0)) return {};
  HeldOut result;
  result.u90 = kSigmaToU90 * std::sqrt(squares / rows);
  const auto count = static_cast<double>(folds.size());
  std::vector<double> left_out;
  double mean = 0;
  for (const auto& fold : folds) {
    left_out.push_back(std::log((squares - fold.squares) / (rows - fold.rows)));
    mean += left_out.back() / count;
  }
  double spread = 0;
  for (const double one : left_out) spread += (one - mean) * (one - mean);
  const double half = t_quantile(0.95, count - 1) * std::sqrt(spread * (count - 1) / count);
  result.low = result.u90 * std::exp(-half / 2);
  result.high = result.u90 * std::exp(half / 2);
  return result;
}

}  // namespace driftwise::calibration
