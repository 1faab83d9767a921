#include "server/application/trajectories/outlook.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace driftwise::application {
namespace {

constexpr int kDraws = 500;
constexpr int kTries = 30;  // for a block that follows such steps
// Steps of a block: longer than a bunch of rereads, much shorter than a run.
constexpr std::size_t kBlock = 30;
// From here on a sum of blocks is as good as normal.
constexpr double kManyBlocks = 100;
// Between runs of one cell, before two of them show it.
constexpr double kBetweenRuns = 0.1;
constexpr double kBetweenRunsWeight = 2;
// Without history: the planned figure, from about half of it to twice as much.
constexpr double kUnknownLevel = 0.5;
constexpr double kUnknownLead_s = 120, kUnknownLeadSpread = 0.8;

std::size_t block_of(std::size_t steps) { return std::clamp<std::size_t>(steps / 3, 1, kBlock); }

// Sum over a stretch of a closed circle, from sums up to each place.
double stretch(const std::vector<double>& sums, std::size_t from, std::size_t length) {
  const std::size_t steps = sums.size() - 1;
  const std::size_t to = from + length;
  if (to <= steps) return sums[to] - sums[from];
  return sums[steps] - sums[from] + sums[to - steps];
}

// The steps before this place were disturbed: what comes next is then not like what comes anywhere.
bool is_disturbed(const std::vector<double>& sums, std::size_t at) {
  constexpr std::size_t kBefore = 3;
  constexpr double kBeyond = 1;  // visits
  const std::size_t from = at < kBefore ? 0 : at - kBefore;
  return sums[at] - sums[from] > kBeyond;
}

struct Level {
  double mean = 1, log_sd = kUnknownLevel;
};

}  // namespace

void take_figures(Outlook& outlook) {
  if (outlook.draws_s.empty()) return;
  auto sorted = outlook.draws_s;
  std::ranges::sort(sorted);
  const std::size_t draws = sorted.size(), middle = draws / 2;
  outlook.expected_s = draws % 2 == 1 ? sorted[middle] : (sorted[middle - 1] + sorted[middle]) / 2;
  const auto held =
      static_cast<std::size_t>(std::ceil(Outlook::kShare * static_cast<double>(draws)));
  std::size_t low = 0;
  for (std::size_t from = 0; from + held <= draws; ++from)
    if (sorted[from + held - 1] - sorted[from] < sorted[low + held - 1] - sorted[low]) low = from;
  outlook.low_s = sorted[low];
  outlook.high_s = sorted[low + held - 1];
}

DurationHistory::Series DurationHistory::series_of(RunSteps steps) {
  Series series;
  series.visits = std::accumulate(steps.visits.begin(), steps.visits.end(), 0.0);
  const double took = std::accumulate(steps.took.begin(), steps.took.end(), 0.0);
  series.level = series.visits > 0 ? took / series.visits : 1;
  series.sums.assign(1, 0);
  for (std::size_t i = 0; i < steps.took.size(); ++i)
    series.sums.push_back(series.sums.back() + steps.took[i] - series.level * steps.visits[i]);
  series.steps = std::move(steps);
  return series;
}

void DurationHistory::add(RunSteps run) {
  if (run.took.size() < kLeastSteps) return;
  runs_.push_back(series_of(std::move(run)));
  if (runs_.size() > kMostRuns) runs_.pop_front();
}

void DurationHistory::add_all(const DurationHistory& newer) {
  for (const auto& run : newer.runs_) add(run.steps);
}

double DurationHistory::level() const {
  if (runs_.empty()) return 1;
  double sum = 0;
  for (const auto& run : runs_) sum += run.level;
  return sum / static_cast<double>(runs_.size());
}

Outlook look_ahead(const DurationHistory& history, const RunAhead& ahead) {
  using Series = DurationHistory::Series;
  Outlook outlook;
  outlook.runs = static_cast<std::int64_t>(history.runs_.size());
  std::vector<const Series*> all;
  for (const auto& run : history.runs_) all.push_back(&run);
  Series own;
  if (ahead.so_far && !ahead.so_far->took.empty()) {
    own = DurationHistory::series_of(*ahead.so_far);
    if (own.steps.took.size() >= DurationHistory::kLeastSteps) all.push_back(&own);
  }

  // Variance of a step within a run, bunches counted: squares of the blocks' sums.
  double variance = 0, counted = 0;
  std::vector<double> chances;
  for (const auto* series : all) {
    const std::size_t steps = series->sums.size() - 1, length = block_of(steps);
    outlook.rows += static_cast<std::int64_t>(steps);
    chances.push_back(static_cast<double>(steps));
    // A block's sum is about the run's own mean: the sum is too small by this.
    const double too_small = 1 - static_cast<double>(length) / static_cast<double>(steps);
    double squares = 0;
    for (std::size_t from = 0; from < steps; ++from) {
      const double sum = stretch(series->sums, from, length);
      squares += sum * sum;
    }
    variance += squares / static_cast<double>(length) / std::max(0.5, too_small);
    counted += static_cast<double>(steps);
  }
  if (counted > 0) variance /= counted;

  // Level of this run: what runs of this cell have, and what this one has had so far.
  Level level;
  const auto runs = static_cast<double>(history.runs_.size());
  if (runs > 0) {
    level.mean = history.level();
    double between = 0, by_chance = 0;
    for (const auto& run : history.runs_) {
      between += (run.level - level.mean) * (run.level - level.mean);
      by_chance += variance / run.visits / runs;
    }
    const double few = kBetweenRuns * level.mean;
    const double seen = runs > 1 ? std::max(0.0, between / (runs - 1) - by_chance) : 0;
    const double spread =
        (kBetweenRunsWeight * few * few + (runs - 1) * seen) / (kBetweenRunsWeight + runs - 1);
    level.log_sd = std::sqrt(spread + (spread + by_chance) / runs) / level.mean;
  }
  if (own.visits > 0) {
    const double prior = std::pow(level.log_sd * level.mean, 2);
    const double of_own = std::max(variance, 0.01 * own.level * own.level) / own.visits;
    const double share = prior / (prior + of_own);
    level.mean += share * (own.level - level.mean);
    level.log_sd = std::sqrt(prior * of_own / (prior + of_own)) / level.mean;
  }

  std::vector<double> leads_s, tails_s;
  for (const auto& run : history.runs_) {
    if (!is_missing(run.steps.lead_s)) leads_s.push_back(run.steps.lead_s);
    if (!is_missing(run.steps.tail_s)) tails_s.push_back(run.steps.tail_s);
  }
  std::mt19937_64 random(ahead.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  const auto one_of = [&](const std::vector<double>& values) {
    return values[static_cast<std::size_t>(uniform(random) * static_cast<double>(values.size()))];
  };
  std::discrete_distribution<std::size_t> which(chances.begin(), chances.end());
  const bool disturbed = !own.sums.empty() && is_disturbed(own.sums, own.sums.size() - 1);
  const auto beyond = [&](double steps) {
    if (all.empty() || steps <= 0) return 0.0;
    if (steps > kManyBlocks * static_cast<double>(kBlock))
      return std::sqrt(steps * variance) * normal(random);
    double sum = 0;
    for (double left = steps; left > 0;) {
      const auto* series = all[which(random)];
      auto place = uniform(random);
      // The first block follows steps like the last ones of this run.
      const auto fits = [&] {
        const auto had = static_cast<double>(series->sums.size() - 1);
        return is_disturbed(series->sums, static_cast<std::size_t>(place * had)) == disturbed;
      };
      for (int more = 0; left == steps && !own.sums.empty() && more < kTries && !fits(); ++more) {
        series = all[which(random)];
        place = uniform(random);
      }
      const auto& sums = series->sums;
      const std::size_t had = sums.size() - 1;
      const auto length = std::min(block_of(had), static_cast<std::size_t>(std::ceil(left)));
      const auto from = static_cast<std::size_t>(place * static_cast<double>(had));
      const double too_small = 1 - static_cast<double>(length) / static_cast<double>(had);
      sum += stretch(sums, from, length) / std::sqrt(std::max(0.5, too_small));
      left -= static_cast<double>(length);
    }
    return sum;
  };
  for (int draw = 0; draw < kDraws; ++draw) {
    const double mean = level.mean * std::exp(level.log_sd * normal(random));
    const double visits = std::max(0.5 * mean * ahead.plan.visits,
                                   mean * ahead.plan.visits + beyond(ahead.plan.visits));
    double total_s = visits * ahead.unit_s + ahead.plan.dwell_s;
    if (!tails_s.empty()) total_s += one_of(tails_s);
    // A wait of unknown length is under way when more was spent than the step should take: what is
    // ahead is then the whole rest.
    double first_s = (ahead.plan.visits > 0 ? mean * ahead.unit_s : 0);
    if (ahead.leads) {
      const double lead_s =
          leads_s.empty()
              ? kUnknownLead_s * std::exp(kUnknownLeadSpread * normal(random))
              : one_of(leads_s) *
                    std::exp(0.3 / std::sqrt(static_cast<double>(leads_s.size())) * normal(random));
      total_s += lead_s;
      first_s = lead_s;
    }
    outlook.draws_s.push_back(std::max(0.0, total_s - std::min(ahead.spent_s, first_s)));
  }
  take_figures(outlook);
  return outlook;
}

}  // namespace driftwise::application
