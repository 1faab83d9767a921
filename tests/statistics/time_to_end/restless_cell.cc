#include "tests/statistics/time_to_end/restless_cell.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/cell_in_memory.h"
#include "tests/unit/application/sqlite.h"

namespace driftwise::tests {
namespace {

class Weather {
 public:
  Weather(const Restlessness& population, std::mt19937& random, CellTime begin)
      : population_(population), random_(random) {
    std::normal_distribution<double> normal(0, population.between_runs);
    factor_ = std::exp(normal(random));
    burst_ = after(begin, population.bursts_per_h);
    absence_ = after(begin, population.absences_per_h);
  }

  // The next instant at which something changes.
  CellTime next() const { return std::min({burst_, burst_end_, absence_, absence_end_}); }
  void change(SmallWorld& world, CellTime now) {
    if (now >= burst_end_) burst_end_ = never();
    if (now >= absence_end_) {
      world.laser_away = false;
      absence_end_ = never();
    }
    if (now >= burst_) {
      burst_end_ = now + nanoseconds_from_s(lasts(population_.burst_s));
      burst_ = after(burst_end_, population_.bursts_per_h);
    }
    if (now >= absence_) {
      world.laser_away = true;
      absence_end_ = now + nanoseconds_from_s(lasts(population_.absence_s));
      absence_ = after(absence_end_, population_.absences_per_h);
    }
  }
  // A group of readings begins.
  void read(SmallWorld& world, int readings) {
    if (burst_end_ == never()) return;
    if (std::bernoulli_distribution(population_.bad_share)(random_))
      world.disturbed_readings = readings;
  }

 private:
  static CellTime never() { return CellTime{std::int64_t{1} << 62}; }
  CellTime after(CellTime from, double per_h) {
    if (per_h <= 0) return never();
    std::exponential_distribution<double> wait_h(per_h * factor_);
    return from + nanoseconds_from_s(3600 * wait_h(random_));
  }
  double lasts(double mean_s) { return std::exponential_distribution<double>(1 / mean_s)(random_); }

  const Restlessness& population_;
  std::mt19937& random_;
  double factor_ = 1;
  CellTime burst_, burst_end_ = never(), absence_, absence_end_ = never();
};

struct Stated {
  CellTime low, high, asked;
};

}  // namespace

Restlessness development_population() { return {"development", 20, 45, 0.5, 4, 60, 0.4, 12, 20}; }

std::vector<Restlessness> development_populations() {
  return {development_population(),
          {"development, rare waits", 2, 40, 0.4, 2, 180, 0.3, 12, 32},
          {"development, very quiet", 1, 30, 0.3, 0.8, 400, 0.2, 10, 30}};
}

std::vector<Restlessness> counted_populations() {
  return {{"bunches of rereads, short waits", 15, 80, 0.4, 8, 30, 0.3, 10, 24},
          {"quiet, rare long waits", 3, 30, 0.3, 1.5, 240, 0.2, 16, 30},
          {"short runs, nights that differ", 30, 40, 0.6, 8, 20, 0.6, 5, 20}};
}

void count_cell(const Restlessness& population, unsigned seed, int before, int runs,
                TimeToEnd& count) {
  std::mt19937 random(seed);
  Folder folder;
  SmallWorld world;
  world.random_state ^= std::uint64_t{seed} << 17;
  const auto description = small_cell(folder / "cell.sqlite");
  CellInMemory cell(world, description, kSqlite);
  std::vector<double> positions_mm;
  for (int i = 0; i < population.rows_of_line; ++i)
    positions_mm.push_back(-4.5 + 9.0 * i / (population.rows_of_line - 1));
  const auto plan = lines_of(population.lines, positions_mm, false);
  for (int run = 0; run < before + runs; ++run) {
    Weather weather(population, random, cell.now());
    RunRecord last;
    std::string phase;
    std::array<Stated, kAskedAt.size()> stated{};
    std::size_t asked = 0;
    const auto watch = cell->runs.watch([&](const application::RunProgress& progress) {
      last = progress.run;
      if (progress.phase == "reading" && phase != "reading")
        weather.read(world, description.run.readings_per_point);
      phase = progress.phase;
      const double done =
          static_cast<double>(progress.run.place.next_row) / static_cast<double>(progress.run.rows);
      if (asked == kAskedAt.size() || done < kAskedAt[asked] || is_over(last.state)) return;
      const auto now = cell.now();
      stated[asked++] = {now + nanoseconds_from_s(progress.outlook.low_s),
                         now + nanoseconds_from_s(progress.outlook.high_s), now};
    });
    last = {};
    asked = 0;
    cell.begin_run(plan);
    while (!(is_over(last.state) && !cell.status().run)) {
      cell.until(
          [&] {
            return (is_over(last.state) && !cell.status().run) || cell.now() >= weather.next();
          },
          10 * 24 * 3600.0);
      weather.change(world, cell.now());
    }
    world.laser_away = false;
    if (last.state != RunState::done) throw std::runtime_error(last.reason);
    if (run < before) continue;
    ++count.runs;
    const double took_h = seconds_from(last.ended - last.started) / 3600;
    count.longest_run_h = std::max(count.longest_run_h, took_h);
    count.shortest_run_h = std::min(count.shortest_run_h, took_h);
    count.rereads_per_row +=
        static_cast<double>(last.attempts) / static_cast<double>(last.rows) - 1;
    for (std::size_t i = 0; i < kAskedAt.size(); ++i) {
      auto& at = count.at[i];
      ++at.asked;
      if (last.ended < stated[i].low)
        ++at.early;
      else if (last.ended > stated[i].high)
        ++at.late;
      else
        ++at.inside;
      at.width_share +=
          seconds_from(stated[i].high - stated[i].low) / seconds_from(last.ended - stated[i].asked);
    }
  }
}

}  // namespace driftwise::tests
