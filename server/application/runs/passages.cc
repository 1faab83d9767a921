#include "server/application/runs/passages.h"

#include <algorithm>
#include <cmath>

#include "server/application/motion/commands.h"
#include "server/application/motion/joining.h"
#include "server/application/motion/loading.h"
#include "server/application/runs/point_visit.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::application {
namespace {

std::int64_t line_of(const ActiveRun& run) {
  if (run.progress.line != 0) return run.progress.line;
  const auto next = next_visit(run.trajectory, run.record.place);
  return next ? run.trajectory.points[static_cast<std::size_t>(next->row)].line : 0;
}

bool is_zero(const Passage& passage) {
  return std::ranges::all_of(passage.commanded_mm, [](double q_mm) { return q_mm == 0; });
}

// Of a place that no instrument was read at: the scales, and what joins of the slow channels.
std::vector<ChannelValue> place_of(const ActiveRun& run, const Passage& passage) {
  const auto& bench = run.scope.bench;
  std::vector<ChannelValue> values;
  const auto motors = bench.description.motor_channels();
  for (std::size_t i = 0; i < std::min(motors.size(), passage.q_mm.size()); ++i)
    values.push_back({motors[i].name(), passage.q_mm[i]});
  if (const auto slow = join_slow_channels(bench.description, bench.recorder.history(),
                                           passage.at.utc, run.plan.rules.max_temperature_age_s))
    values.insert(values.end(), slow->begin(), slow->end());
  return values;
}

std::vector<PointRecord> passage_rows(const ActiveRun& run, std::size_t count) {
  std::vector<PointRecord> rows;
  for (std::size_t i = 0; i < count; ++i) {
    const auto& passage = run.scope.passed[i];
    PointRecord row;
    row.run = run.record.id;
    row.datum = run.datum->id;
    row.line = line_of(run);
    row.zero = is_zero(passage);
    row.passage = true;
    row.measured = passage.at;
    row.dwell_s = seconds_from(passage.at.utc - passage.in_position);
    row.values = passage.values.empty() ? place_of(run, passage) : passage.values;
    set_commands(run.scope.bench.description, passage.commanded_mm, row);
    const auto force = run.scope.bench.description.force_channel();
    const auto is_force = [&force](const auto& value) { return value.channel == force->name(); };
    if (force && passage.force_n && std::ranges::none_of(row.values, is_force))
      row.values.push_back({force->name(), *passage.force_n});
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

std::vector<PointRecord> passages_behind(const ActiveRun& run) {
  const auto waiting = run.scope.passed.size();
  return passage_rows(run, waiting > 0 ? waiting - 1 : 0);
}

void drop_passages(ActiveRun& run, std::size_t stored, bool has_point) {
  auto& passed = run.scope.passed;
  const std::size_t dropped = has_point ? passed.size() : stored;
  if (dropped > 0) run.last_stored_mm = passed[dropped - 1].q_mm;
  if (has_point)
    passed.clear();
  else
    passed.erase(passed.begin(), passed.begin() + static_cast<std::ptrdiff_t>(stored));
}

void note_passage_read(ActiveRun& run, const std::vector<ChannelValue>& values, Stamp measured) {
  auto& passed = run.scope.passed;
  if (passed.empty() || !passed.back().values.empty()) return;  // the axes were there already
  passed.back().values = values;
  passed.back().at = measured;
}

Awaitable<void> note_stand(ActiveRun& run) {
  auto& bench = run.scope.bench;
  if (!run.datum || bench.description.motor_channels().empty()) co_return;
  const auto state = co_await bench.devices.motion_state();
  if (!state || state->moving || !state->referenced) co_return;
  auto& passed = run.scope.passed;
  const auto& known_mm = passed.empty() ? run.last_stored_mm : passed.back().q_mm;
  bool is_elsewhere = false;
  for (std::size_t i = 0; i < std::min(known_mm.size(), state->q_mm.size()); ++i)
    is_elsewhere = is_elsewhere || std::abs(nm_from_mm(state->q_mm[i] - known_mm[i])) >
                                       run.plan.rules.in_position_nm;
  if (!is_elsewhere) co_return;
  const auto now = bench.clock.now();
  passed.push_back({now.utc, now, state->q_mm, state->q_mm, bench.loading.known_n(), {}});
}

void note_zeroing(ActiveRun& run) {
  auto& passed = run.scope.passed;
  if (run.record.accepted == 0) passed.clear();
  const auto motors = run.scope.bench.description.motor_channels();
  Passage zero;
  zero.in_position = run.datum->opened.utc;
  zero.at = run.datum->opened;
  zero.commanded_mm.assign(motors.size(), 0.0);
  for (const auto& motor : motors) {
    const double* q_mm = find_value(run.datum->values, motor.name());
    zero.q_mm.push_back(q_mm ? *q_mm : 0.0);
  }
  zero.force_n = run.scope.bench.loading.known_n();
  // The arrival that led to it is the same place.
  if (!passed.empty() && passed.back().values.empty() && is_zero(passed.back())) passed.pop_back();
  passed.push_back(std::move(zero));
}

Awaitable<Result<void>> store_passages(ActiveRun& run) {
  const std::size_t count = run.scope.passed.size();
  if (count == 0) co_return Result<void>{};
  PointCommit commit;
  commit.run = run.record.id;
  commit.place = run.record.place;
  commit.passages = passage_rows(run, count);
  auto storing = commit_until_stored(run.scope, std::move(commit));
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(storing));
  drop_passages(run, count, false);
  co_return Result<void>{};
}

}  // namespace driftwise::application
