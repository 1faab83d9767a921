#include "server/application/runs/point_visit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/application/motion/commands.h"
#include "server/application/motion/joining.h"
#include "server/application/motion/keep_out.h"
#include "server/application/motion/loading.h"
#include "server/application/motion/motion.h"
#include "server/application/motion/point_decision.h"
#include "server/application/motion/sampling.h"
#include "server/application/motion/sampling_gates.h"
#include "server/application/motion/until_stored.h"
#include "server/application/runs/passages.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

const TrajectoryPoint& row_of(const ActiveRun& run, std::int64_t row) {
  return run.trajectory.points[static_cast<std::size_t>(row)];
}

// A little way from the point back towards where it was reached from, so that it is approached anew
// from the side that the plan gave it: a robot with play stands elsewhere when it comes from the
// other one. Where that is not known, towards the zero; at the zero, to whichever side is allowed.
std::vector<double> aside_of(const ActiveRun& run, std::vector<double> q_mm) {
  const double away_mm = run.plan.rules.reapproach_mm;
  const auto axes = run.scope.bench.description.axes();
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (!run.scope.moved.contains(i)) continue;
    double& q = q_mm[i];
    const char side = i < run.scope.sides.size() ? run.scope.sides[i] : '?';
    const bool from_above = side == '+' || (side == '?' && q <= 0);
    q += from_above ? away_mm : -away_mm;
    q = std::clamp(q, axes[i].min_mm, axes[i].max_mm);
  }
  return q_mm;
}

struct Attempt {
  Trouble trouble = Trouble::none;
  std::optional<PointRecord> point;  // complete, when there is no trouble
};

PointRecord make_point(const ActiveRun& run, const Visit& visit, const RowCommand& command,
                       const Arrival& arrival, const Sampling& sampling,
                       const std::vector<ChannelValue>& slow) {
  const auto& row = row_of(run, visit.row);
  PointRecord point;
  point.run = run.record.id;
  point.row = visit.row;
  point.datum = run.datum->id;
  point.set = row.set;
  point.line = row.line;
  point.zero = row.zero;
  point.measured = sampling.measured;
  point.dwell_s = seconds_from(sampling.measured.utc - arrival.in_position.utc);
  const auto motors = run.scope.bench.description.motor_channels();
  for (std::size_t i = 0; i < motors.size(); ++i)
    point.values.push_back({motors[i].name(), sampling.q_mm[i]});
  set_commands(run.scope.bench.description, command.q_mm, point);
  for (const auto& length : run.scope.bench.description.length_channels()) {
    if (const double* mean = find_value(sampling.means, length.name()))
      point.values.push_back({length.name(), *mean});
    if (const double* spread = find_value(sampling.spreads_nm, length.symbol + "_std_nm"))
      point.values.push_back({length.symbol + "_std_nm", *spread});
  }
  point.values.insert(point.values.end(), slow.begin(), slow.end());
  for (const auto& mean : sampling.means)
    if (!find_value(point.values, mean.channel)) point.values.push_back(mean);
  const auto force = run.scope.bench.description.force_channel();
  if (const auto known_n = run.scope.bench.loading.known_n(); force && known_n)
    point.values.push_back({force->name(), *known_n});
  // The pose that was wanted, with what came of it: compensated or not, for a comparison.
  if (is_pose_symbol(without_robot(run.trajectory.coordinates.front().symbol)))
    for (std::size_t i = 0; i < run.trajectory.coordinates.size(); ++i) {
      const auto& wanted = run.trajectory.coordinates[i];
      point.values.push_back({wanted.symbol + "_target_" + wanted.unit, command.target[i]});
    }
  return point;
}

// Reads and judges; the axis stands where it should.
Awaitable<Result<Attempt>> read_point(ActiveRun& run, const Visit& visit, const RowCommand& command,
                                      const Arrival& arrival, AttemptRecord& record) {
  const auto& rules = run.plan.rules;
  DRIFTWISE_CO_TRY(auto sampling,
                   co_await take_readings(run.scope, rules.readings_per_point, command.q_mm));
  record.readings = sampling.readings;
  record.spread_nm = sampling.spread_nm;
  run.progress.last_spread_nm = sampling.spread_nm;
  auto found = judge_sampling(sampling, rules, run.scope.bench.devices.setup());
  if (found.trouble != Trouble::none) {
    record.reason = std::move(found.sentence);
    co_return Attempt{found.trouble, {}};
  }
  DRIFTWISE_CO_TRY(const auto slow, co_await join_when_scanned(run.scope, sampling.measured.utc));
  co_return Attempt{Trouble::none, make_point(run, visit, command, arrival, sampling, slow)};
}

// What stands between two attempts of one visit.
struct Stand {
  RowCommand command;
  Arrival arrival;
};

Awaitable<Result<void>> come_to_row(ActiveRun& run, const Visit& visit,
                                    const CommandFor& command_for, bool anew, Stand& stand) {
  const auto& row = row_of(run, visit.row);
  if (anew) {
    auto aside_mm = aside_of(run, stand.command.q_mm);
    // A row without room beside it for all robots is approached from where they are.
    if (check_keep_out(run.scope.bench.description, stand.command.q_mm, aside_mm))
      DRIFTWISE_CO_RETURN_IF_ERROR(co_await go_to(run.scope, std::move(aside_mm),
                                                  fmt::format("aside of row {}", visit.row + 1),
                                                  run.scope.moved));
  }
  DRIFTWISE_CO_TRY(auto command, command_for(run, row));
  stand.command = std::move(command);
  DRIFTWISE_CO_TRY(auto arrival,
                   co_await go_to(run.scope, stand.command.q_mm,
                                  fmt::format("row {}", visit.row + 1), run.scope.moved));
  stand.arrival = std::move(arrival);
  if (row.dwell_s && stand.arrival.trouble == Trouble::none) {
    run.scope.phase("dwelling");
    co_return co_await run.scope.sleep_until(stand.arrival.in_position.utc +
                                             nanoseconds_from_s(*row.dwell_s));
  }
  co_return Result<void>{};
}

Awaitable<Result<Attempt>> try_once(ActiveRun& run, const Visit& visit,
                                    const CommandFor& command_for, std::optional<Verdict> before,
                                    Stand& stand, AttemptRecord& record) {
  if (before != Verdict::reread) {
    const bool anew = before == Verdict::reapproach;
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await come_to_row(run, visit, command_for, anew, stand));
    if (stand.arrival.trouble != Trouble::none) {
      record.reason = stand.arrival.sentence;
      co_return Attempt{stand.arrival.trouble, {}};
    }
  }
  co_return co_await read_point(run, visit, stand.command, stand.arrival, record);
}

void take_over(ActiveRun& run, const PointCommit& commit) {
  drop_passages(run, commit.passages.size(), commit.point.has_value());
  auto& record = run.record;
  record.place = commit.place;
  ++record.attempts;
  if (commit.point) ++record.accepted;
  if (commit.attempts.back().verdict == Verdict::given_up) ++record.given_up;
}

}  // namespace

Awaitable<Result<std::optional<PointId>>> commit_until_stored(RunScope& scope, PointCommit commit) {
  const auto store = [&scope, &commit] { return scope.bench.writer.commit(commit); };
  auto storing = until_stored(scope, store);
  co_return co_await std::move(storing);
}

Awaitable<Result<VisitResult>> visit_row(ActiveRun& run, Visit visit,
                                         const CommandFor& command_for) {
  AttemptTally tally{0, 0, visit.requeues};
  std::optional<Verdict> before;
  Stand stand;
  auto& clock = run.scope.bench.clock;
  while (true) {
    AttemptRecord record;
    record.row = visit.row;
    record.number = ++run.attempts_of_row[visit.row];
    record.started = clock.now();
    auto attempt = co_await try_once(run, visit, command_for, before, stand, record);
    record.ended = clock.now();
    if (!attempt) {
      record.verdict = Verdict::interrupted;
      record.reason = attempt.error().message;
      PointCommit interrupted{run.record.id, {std::move(record)}, {}, {}, {}, run.record.place};
      interrupted.passages = passages_behind(run);
      // Best effort: the error at hand is the one to tell, and a restart records the interruption
      // anyway.
      if (co_await run.scope.bench.writer.commit(interrupted)) take_over(run, interrupted);
      co_return tl::unexpected(attempt.error());
    }
    record.verdict = decide(attempt->trouble, tally, run.plan.rules);
    const Verdict verdict = record.verdict;
    PointCommit commit{run.record.id,
                       {std::move(record)},
                       std::move(attempt->point),
                       {},
                       {},
                       place_after(run.record.place, visit, verdict)};
    commit.passages = passages_behind(run);
    run.scope.phase("storing");
    DRIFTWISE_CO_TRY(auto stored, co_await commit_until_stored(run.scope, commit));
    take_over(run, commit);
    if (verdict != Verdict::reread && verdict != Verdict::reapproach) {
      if (commit.point && stored) commit.point->id = *stored;
      co_return VisitResult{verdict, std::move(commit.point)};
    }
    tally = after(tally, verdict);
    before = verdict;
  }
}

}  // namespace driftwise::application
