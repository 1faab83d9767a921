#include "server/diagnosis/search/wave_columns.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/core/units.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::size_t kFewestCells = 8;
constexpr std::size_t kRowsAtOnce = 2048;  // stay in the cache
constexpr double kUniform = 1e-9;          // of the first frequency

struct Grid {
  std::vector<double> frequencies;  // turns per unit of the value
  std::string symbol;               // "" for time
  bool length = false;              // periods in nm, values in mm
};

// "sin(x, 2000 nm)" beside "cos(x, 2000 nm)"; frequencies per mm, arcsec or s.
std::optional<Grid> grid_of(const Cause& cause) {
  if (cause.scale != ParameterScale::inverse || cause.cells.size() < kFewestCells)
    return std::nullopt;
  const auto& terms = cause.cells.front().terms;
  if (terms.size() != 2) return std::nullopt;
  Grid grid;
  for (std::size_t k = 0; k < 2; ++k) {
    if (terms[k].factors.size() != 1) return std::nullopt;
    const auto* call = std::get_if<effects::Call>(&terms[k].factors.front());
    const std::string name = k == 0 ? "sin" : "cos";
    if (call == nullptr || (call->effect != name && call->effect != name + "_t"))
      return std::nullopt;
    grid.symbol = call->symbols.empty() ? "" : call->symbols.front();
    grid.length = call->parameters.front().unit == "nm";
  }
  const auto frequency = [&](std::size_t c) {
    const double period = cause.cells[c].parameter;
    return 1 / (grid.length ? mm_from_nm(period) : period);
  };
  for (std::size_t c = 0; c < cause.cells.size(); ++c) grid.frequencies.push_back(frequency(c));
  return grid;
}

}  // namespace

std::optional<Eigen::MatrixXd> wave_columns(const Problem& problem, const Cause& cause,
                                            const std::function<bool()>& tick) {
  const auto grid = grid_of(cause);
  if (!grid) return std::nullopt;
  const auto values = problem.prepared.phase_values(grid->symbol);
  if (values.empty()) return std::nullopt;
  for (const std::size_t row : problem.learn)
    if (!std::isfinite(values[row])) return std::nullopt;
  const auto cells = static_cast<Eigen::Index>(cause.cells.size());
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(problem.timeline.rows(), 2 * cells);
  Eigen::VectorXd count = Eigen::VectorXd::Zero(problem.timeline.rows());
  const auto& learn = problem.learn;
  const std::vector<std::size_t>& block = problem.block_of;
  for (std::size_t begin = 0; begin < learn.size(); begin += kRowsAtOnce) {
    if (tick && !tick()) return std::nullopt;
    const std::size_t rows = std::min(kRowsAtOnce, learn.size() - begin);
    const auto n = static_cast<Eigen::Index>(rows);
    Eigen::ArrayXd sine(n), cosine(n), turn_sine(n), turn_cosine(n), kept(n);
    const auto turned = [&](Eigen::Index i, double frequency) {
      return 2 * std::numbers::pi *
             std::remainder(values[learn[begin + static_cast<std::size_t>(i)]] * frequency, 1.0);
    };
    for (Eigen::Index i = 0; i < n; ++i)
      count[static_cast<Eigen::Index>(block[begin + static_cast<std::size_t>(i)])] += 1;
    double step = NAN;  // that turn_sine and turn_cosine are of
    for (Eigen::Index c = 0; c < cells; ++c) {
      const auto at = static_cast<std::size_t>(c);
      const double here_step = c > 0 ? grid->frequencies[at] - grid->frequencies[at - 1] : NAN;
      if (c > 0 && std::abs(here_step - step) <= kUniform * grid->frequencies.front()) {
        kept = sine * turn_cosine + cosine * turn_sine;
        cosine = cosine * turn_cosine - sine * turn_sine;
        sine.swap(kept);
      } else {
        for (Eigen::Index i = 0; i < n; ++i) {
          const double phase = turned(i, grid->frequencies[at]);
          sine[i] = std::sin(phase);
          cosine[i] = std::cos(phase);
        }
        step = at + 1 < grid->frequencies.size() ? grid->frequencies[at + 1] - grid->frequencies[at]
                                                 : NAN;
        const bool goes_on = at + 2 < grid->frequencies.size() &&
                             std::abs(grid->frequencies[at + 2] - grid->frequencies[at + 1] -
                                      step) <= kUniform * grid->frequencies.front();
        if (!goes_on) step = NAN;
        for (Eigen::Index i = 0; goes_on && i < n; ++i) {
          const double phase = turned(i, step);
          turn_sine[i] = std::sin(phase);
          turn_cosine[i] = std::cos(phase);
        }
      }
      for (std::size_t from = 0; from < rows;) {
        const std::size_t here = block[begin + from];
        std::size_t to = from + 1;
        while (to < rows && block[begin + to] == here) ++to;
        const auto first = static_cast<Eigen::Index>(from);
        const auto length = static_cast<Eigen::Index>(to - from);
        columns(static_cast<Eigen::Index>(here), 2 * c) += sine.segment(first, length).sum();
        columns(static_cast<Eigen::Index>(here), 2 * c + 1) += cosine.segment(first, length).sum();
        from = to;
      }
    }
  }
  columns.array().colwise() /= count.array();
  return columns;
}

}  // namespace driftwise::diagnosis
