#include "server/diagnosis/search/search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace driftwise::diagnosis {
namespace {

constexpr int kFirstNulls = 49;
constexpr double kClearlyNothing = 0.08, kClearlyThere = 1e-3;  // the second: of alpha
constexpr std::size_t kTopCauses = 3, kMostShapes = 6;
constexpr double kInTheRunning = 20;  // of 2 ln L below the best
constexpr double kShortSteps = 3;     // correlation times that no slow effect is mistaken for

std::vector<NoiseShape> unique(std::vector<NoiseShape> shapes) {
  std::vector<NoiseShape> kept;
  for (const auto& shape : shapes)
    if (std::ranges::find(kept, shape) == kept.end()) kept.push_back(shape);
  return kept;
}

std::size_t best_of(const Ground& ground, Eigen::Index output, double longest_tau_s) {
  std::size_t best = 0;
  for (std::size_t s = 1; s < ground.shape_count(); ++s)
    if (ground.shape(s).tau_s <= longest_tau_s &&
        ground.worse_by(s, output) < ground.worse_by(best, output))
      best = s;
  return best;
}

}  // namespace

Search::Search(const Timeline& timeline, const Eigen::MatrixXd& series, Bank bank,
               SearchOptions options)
    : timeline_(timeline),
      series_(series),
      bank_(std::move(bank)),
      options_(std::move(options)),
      grid_(noise_grid(timeline)),
      chance_{std::vector<double>(bank_.entries.size(), 0), {}} {}

// The noise as it looks without any further effect, and as it would with each of those that look
// best under different guesses of it.
std::vector<NoiseShape> Search::shapes_in_question(const SoftBase& base,
                                                   const std::vector<char>& allowed,
                                                   bool& stopped) const {
  const Ground whole(timeline_, grid_, base, series_, options_.tick);
  const double step_s = grid_.size() > 1 ? grid_[1].tau_s : 1;
  std::vector<NoiseShape> shapes, guesses;
  for (Eigen::Index o = 0; o < whole.outputs(); ++o) {
    shapes.push_back(whole.noise(o));
    guesses.push_back(whole.noise(o));
    guesses.push_back(whole.shape(best_of(whole, o, kShortSteps * step_s)));
  }
  if (bank_.entries.empty()) return unique(std::move(shapes));
  guesses.push_back(grid_.front());  // white
  std::vector<Eigen::MatrixXd> series;
  for (Eigen::Index o = 0; o < series_.cols(); ++o) series.emplace_back(series_.col(o));
  struct Candidate {
    std::size_t cause, cell;
    Gain gain;
  };
  std::vector<Candidate> candidates;
  double top = 0;
  for (const auto& guess : unique(guesses)) {
    const Ground ground(timeline_, {guess}, base, series_);
    const auto best = scan(bank_, ground, series, allowed, {options_.executor, options_.tick});
    if (best.empty()) {
      stopped = true;
      return {};
    }
    std::vector<std::size_t> order(best.size());
    for (std::size_t c = 0; c < order.size(); ++c) order[c] = c;
    std::ranges::stable_sort(order, std::ranges::greater{},
                             [&](std::size_t c) { return best[c][0].evidence; });
    for (std::size_t i = 0; i < std::min(kTopCauses, order.size()); ++i) {
      const auto& entry = bank_.entries[order[i]];
      const std::size_t cell = best[order[i]][0].cell;
      const auto known = [&](const Candidate& one) {
        return one.cause == order[i] && one.cell == cell;
      };
      if (std::ranges::any_of(candidates, known)) continue;
      if (options_.tick && !options_.tick()) {
        stopped = true;
        return {};
      }
      const auto& at = bank_.cells[entry.first + cell];
      candidates.push_back({order[i], cell,
                            whole.gain(bank_.columns.middleCols(at.first, at.count),
                                       bank_.prior.middleRows(at.first, at.count))});
      top = std::max(top, candidates.back().gain.gain);
    }
  }
  std::ranges::stable_sort(candidates, std::ranges::greater{},
                           [](const Candidate& one) { return one.gain.gain; });
  for (const auto& one : candidates)
    if (one.gain.gain > top - kInTheRunning)
      for (const std::size_t s : one.gain.shape) shapes.push_back(grid_[s]);
  shapes = unique(shapes);
  const std::size_t most = kMostShapes + static_cast<std::size_t>(series_.cols()) - 1;
  if (shapes.size() > most) shapes.resize(most);
  return shapes;
}

namespace {

std::vector<Standing> standings(const std::vector<std::vector<Best>>& best,
                                const std::vector<double>& of_chance) {
  std::vector<Standing> result;
  for (std::size_t c = 0; c < best.size(); ++c)
    result.push_back({best[c][0].evidence, best[c][0].evidence - of_chance[c], best[c][0].gain,
                      best[c][0].cell});
  return result;
}

}  // namespace

void Search::choose_first(Look& look) const {
  look.first.reset();
  const auto furthest = std::ranges::max_element(look.causes, {}, &Standing::beyond);
  if (furthest == look.causes.end() || !(furthest->beyond > 0)) return;
  auto first = furthest;
  for (auto one = look.causes.begin(); one != look.causes.end(); ++one)
    if (chance_.tail.p(one->beyond) <= options_.alpha && one->evidence > first->evidence)
      first = one;
  look.first = static_cast<std::size_t>(first - look.causes.begin());
  look.p_adjusted = chance_.tail.p(first->beyond);
}

std::optional<Look> Search::look(const SoftBase& base, const std::vector<char>& allowed) {
  bool stopped = false;
  Look result;
  result.shapes = shapes_in_question(base, allowed, stopped);
  if (stopped) return std::nullopt;
  if (bank_.entries.empty()) return result;  // no cause can be asked of these data
  const Ground ground(timeline_, result.shapes, base, series_);
  const auto outputs = static_cast<std::size_t>(series_.cols());
  std::vector<NoiseShape> noise;
  for (std::size_t o = 0; o < outputs; ++o)
    noise.push_back(ground.noise(static_cast<Eigen::Index>(o)));
  const Eigen::MatrixXd mixing = ground.correlation().llt().matrixL();
  std::mt19937_64 random(options_.seed);
  std::vector<std::vector<Best>> best;
  for (const int more : {std::min(kFirstNulls, options_.nulls), options_.nulls - kFirstNulls}) {
    if (more <= 0) break;
    const bool with_data = best.empty();
    std::vector<Eigen::MatrixXd> series(
        outputs, Eigen::MatrixXd(series_.rows(), more + (with_data ? 1 : 0)));
    for (Eigen::Index k = 0; k < series.front().cols(); ++k) {
      const Eigen::MatrixXd drawn =
          with_data && k == 0 ? series_
                              : Eigen::MatrixXd(simulated_noise(timeline_, noise, mixing, random) +
                                                drawn_hidden(base, series_.cols(), random));
      for (std::size_t o = 0; o < outputs; ++o)
        series[o].col(k) = drawn.col(static_cast<Eigen::Index>(o));
    }
    auto found = scan(bank_, ground, series, allowed, {options_.executor, options_.tick});
    if (found.empty()) return std::nullopt;
    if (with_data)
      best = std::move(found);
    else
      for (std::size_t c = 0; c < best.size(); ++c)
        best[c].insert(best[c].end(), found[c].begin(), found[c].end());
    result.nulls += more;
    std::vector<double> maxima(static_cast<std::size_t>(result.nulls), -1e300);
    for (std::size_t c = 0; c < best.size(); ++c) {
      if (allowed[c] == 0) continue;
      std::vector<double> own;
      for (std::size_t k = 0; k < maxima.size(); ++k) own.push_back(best[c][k + 1].evidence);
      chance_.of_cause[c] = EvidenceTail(own).location();
      for (std::size_t k = 0; k < maxima.size(); ++k)
        maxima[k] = std::max(maxima[k], own[k] - chance_.of_cause[c]);
    }
    result.tail = chance_.tail = EvidenceTail(maxima);
    result.causes = standings(best, chance_.of_cause);
    choose_first(result);
    if (!result.first) return result;
    if (result.p_adjusted > kClearlyNothing || result.p_adjusted < kClearlyThere * options_.alpha)
      break;
  }
  return result;
}

std::optional<Look> Search::compare(const SoftBase& base, const std::vector<char>& allowed) const {
  bool stopped = false;
  Look result;
  result.shapes = shapes_in_question(base, allowed, stopped);
  if (stopped) return std::nullopt;
  if (bank_.entries.empty()) return result;  // no cause can be asked of these data
  const Ground ground(timeline_, result.shapes, base, series_);
  std::vector<Eigen::MatrixXd> series;
  for (Eigen::Index o = 0; o < series_.cols(); ++o) series.emplace_back(series_.col(o));
  const auto best = scan(bank_, ground, series, allowed, {options_.executor, options_.tick});
  if (best.empty()) return std::nullopt;
  result.causes = standings(best, chance_.of_cause);
  result.tail = chance_.tail;
  choose_first(result);
  return result;
}

}  // namespace driftwise::diagnosis
