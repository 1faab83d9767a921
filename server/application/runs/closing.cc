// Returns to zero: judged with their budget, stored, and what follows from them.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/application/motion/joining.h"
#include "server/application/motion/keep_out.h"
#include "server/application/motion/loading.h"
#include "server/application/motion/motion.h"
#include "server/application/motion/sampling.h"
#include "server/application/motion/until_stored.h"
#include "server/application/motion/zero_visit.h"
#include "server/application/runs/passages.h"
#include "server/application/runs/run_engine.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::application {
namespace {

using plausibility::Closure;
using plausibility::ExpectedClosure;

double entry(const std::vector<double>& values, std::size_t i) {
  return i < values.size() && !is_missing(values[i]) ? values[i] : 0.0;
}

double largest_warming_k(const Closure& closure, const Closure& before) {
  double largest = 0;
  for (std::size_t i = 0; i < closure.warming_k.size(); ++i) {
    const double k = entry(closure.warming_k, i) - entry(before.warming_k, i);
    if (std::abs(k) > std::abs(largest)) largest = k;
  }
  return largest;
}

// By the serving model where it answers at both instants, else by the run's own earlier returns.
ExpectedClosure expectation(const ActiveRun& run, const Closure& closure) {
  const auto& before = run.closure_judge.reference(closure);
  ExpectedClosure expected;
  expected.warming_k = largest_warming_k(closure, before);
  const auto lengths = run.scope.bench.description.length_channels().size();
  if (!closure.model.empty() && closure.model == before.model) {
    for (std::size_t i = 0; i < closure.model_pose.size(); ++i)
      (i < lengths ? expected.lengths_nm : expected.angles_arcsec)
          .push_back(entry(closure.model_pose, i) - entry(before.model_pose, i));
    expected.lengths_sd_nm.assign(lengths, 0.0);
    expected.by = closure.model;
    return expected;
  }
  auto then_k = before.warming_k;
  then_k.resize(closure.warming_k.size(), 0.0);
  std::size_t returns = 0;
  for (std::size_t i = 0; i < lengths; ++i) {
    const std::vector<ZeroObservation> none;
    const auto& seen = i < run.closures.size() ? run.closures[i] : none;
    const auto now = predict_zero_shift(seen, closure.warming_k);
    const auto then = predict_zero_shift(seen, then_k);
    expected.lengths_nm.push_back(now.shift_nm - then.shift_nm);
    // Of the change alone: the datum's own error is in both.
    std::vector<double> change_k(closure.warming_k.size());
    for (std::size_t k = 0; k < change_k.size(); ++k)
      change_k[k] = entry(closure.warming_k, k) - entry(then_k, k);
    expected.lengths_sd_nm.push_back(predict_zero_shift(seen, change_k).sd_nm);
    returns = std::max(returns, now.observations);
  }
  if (returns > 0)
    expected.by = fmt::format("{} earlier return{}", returns, returns == 1 ? "" : "s");
  return expected;
}

std::string side_text(const CellDescription& cell, const std::string& sides) {
  std::string text;
  const auto motors = cell.motor_channels();
  for (std::size_t i = 0; i < std::min(motors.size(), sides.size()); ++i)
    if (sides[i] != '?') text += (text.empty() ? "" : " ") + motors[i].symbol + sides[i];
  return text;
}

std::string drift_text(const ActiveRun& run, const std::vector<double>& closure, double largest_nm,
                       std::int64_t line) {
  std::vector<double> measured_nm = closure;
  std::erase_if(measured_nm, is_missing);
  std::string by_length;
  if (measured_nm.size() > 1)
    by_length = fmt::format(" at most ({:+.1f})", fmt::join(measured_nm, ", "));
  return fmt::format("line {}: back at zero {:+.1f} nm{} from where datum {} had it", line,
                     largest_nm, by_length, run.datum->id.value);
}

// The coordinate that is farthest in terms of its limit.
std::string within_sentence(const ClosureRecord& record) {
  const ClosureCoordinate* worst = nullptr;
  double farthest = -1;
  for (const auto& one : record.coordinates)
    if (const double share = std::abs(one.found) / one.limit; share > farthest) {
      farthest = share;
      worst = &one;
    }
  if (worst == nullptr) return {};
  const bool angle = worst->channel.ends_with("_arcsec");
  return fmt::format("{} moved by {:+.{}f} {} (limit {:.{}f}): accept", worst->channel,
                     worst->found, angle ? 2 : 0, angle ? "arcsec" : "nm", worst->limit,
                     angle ? 1 : 0);
}

// Of each coordinate: from this side minus from the other one.
void set_play(const CellDescription& cell, const Closure& here, const Closure& there,
              ClosureRecord& record) {
  const auto set = [&record](const std::vector<Channel>& channels, const std::vector<double>& a,
                             const std::vector<double>& b) {
    for (auto& one : record.coordinates)
      for (std::size_t i = 0; i < channels.size(); ++i)
        if (channels[i].name() == one.channel) one.play = entry(a, i) - entry(b, i);
  };
  set(cell.length_channels(), here.lengths_nm, there.lengths_nm);
  set(cell.angle_channels(), here.angles_arcsec, there.angles_arcsec);
}

std::int64_t line_since_return(const ActiveRun& run, std::int64_t line) {
  if (run.since_return.rows.empty()) return line;
  const auto row = static_cast<std::size_t>(run.since_return.rows.begin()->first);
  return run.trajectory.points[row].line;
}

// What the run's own returns teach about the temperatures: without play and marked jumps.
void learn(ActiveRun& run, const Closure& closure) {
  auto lengths_nm = closure.lengths_nm;
  for (std::size_t i = 0; i < lengths_nm.size(); ++i)
    lengths_nm[i] -= entry(run.jumped_nm, i) + run.closure_judge.play(closure.side, i);
  add_closure(run.closures, closure.warming_k, lengths_nm);
}

// While the disk takes nothing the run waits here.
Awaitable<Result<void>> store_closure(RunScope& scope, ClosureRecord record,
                                      std::optional<RepeatedLine> repeated) {
  const auto store = [&] { return scope.bench.writer.closures().add_closure(record, repeated); };
  auto storing = until_stored(scope, store);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(storing));
  co_return Result<void>{};
}

}  // namespace

Closure RunEngine::closure_of(const ActiveRun& run, const std::vector<ChannelValue>& values,
                              CellTime measured) const {
  const auto& cell = bench_.description;
  Closure closure;
  closure.at = measured;
  closure.lengths_nm = closure_nm(cell, *run.datum, values);
  for (const auto& angle : cell.angle_channels()) {
    const double* arcsec = find_value(values, angle.name());
    closure.angles_arcsec.push_back(arcsec ? *arcsec : kMissing);
  }
  closure.force_n = bench_.loading.known_n();
  closure.side = run.scope.sides;
  closure.warming_k = warming_since(cell, *run.datum, values);
  auto stated = values;
  if (const auto force = cell.force_channel(); force && closure.force_n)
    stated.push_back({force->name(), *closure.force_n});
  const auto pose = hooks_.model_pose ? hooks_.model_pose(stated) : std::nullopt;
  if (!pose) return closure;
  closure.model = fmt::format("model {}", pose->model.value);
  // With one axis the scale's own reading is taken out of what is found (closure_nm).
  const auto motors = cell.motor_channels();
  const bool one_axis = motors.size() == 1 && cell.length_channels().size() == 1;
  const double* q_mm = one_axis ? find_value(values, motors.front().name()) : nullptr;
  for (const auto& length : cell.length_channels()) {
    const double* mm = find_value(pose->values, length.name());
    closure.model_pose.push_back(mm ? nm_from_mm(*mm - (q_mm ? *q_mm : 0.0)) : kMissing);
  }
  for (const auto& angle : cell.angle_channels()) {
    const double* arcsec = find_value(pose->values, angle.name());
    closure.model_pose.push_back(arcsec ? *arcsec : kMissing);
  }
  return closure;
}

Closure RunEngine::zero_of_datum(const ActiveRun& run) const {
  auto zero = closure_of(run, run.datum->values, run.datum->opened.utc);
  zero.lengths_nm.clear();  // it counts from here
  zero.angles_arcsec.clear();
  return zero;
}

Awaitable<Result<std::vector<ChannelValue>>> RunEngine::visit_zero_and_join(ActiveRun& run,
                                                                            std::string cause,
                                                                            Stamp& measured) {
  ZeroVisit visit;
  visit.cause = std::move(cause);
  visit.took = [this](Sampling& sampling) {
    for (auto& reading : sampling.readings) bench_.writer.add(std::move(reading));
  };
  auto visiting = visit_zero(run.scope, std::move(visit));
  DRIFTWISE_CO_TRY(const auto sampling, co_await std::move(visiting));
  DRIFTWISE_CO_TRY(auto values, co_await join_when_scanned(run.scope, sampling.measured.utc));
  const auto motors = bench_.description.motor_channels();
  for (std::size_t i = 0; i < motors.size(); ++i)
    values.push_back({motors[i].name(), sampling.q_mm[i]});
  values.insert(values.end(), sampling.means.begin(), sampling.means.end());
  measured = sampling.measured;
  note_passage_read(run, values, measured);
  auto storing = store_passages(run);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(storing));
  co_return values;
}

Awaitable<Result<void>> RunEngine::go_to_zero(ActiveRun& run, std::string why) {
  const std::vector<double> zero_mm(bench_.description.motor_channels().size(), 0.0);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await go_to(run.scope, zero_mm, std::move(why)));
  co_return Result<void>{};
}

Awaitable<Result<void>> RunEngine::return_to_zero(ActiveRun& run) {
  const auto last = static_cast<std::size_t>(run.since_return.last_row);
  const auto line = run.trajectory.points[last].line;
  Stamp measured;
  auto visiting = visit_zero_and_join(run, fmt::format("zero after line {}", line), measured);
  DRIFTWISE_CO_TRY(auto values, co_await std::move(visiting));
  auto noting = note_closure(run, std::move(values), measured, line);
  if (auto ok = co_await std::move(noting); !ok) co_return ok;
  run.since_return.returned = true;  // also where no instrument measures it
  co_return co_await store_lag(run);
}

// The zero once more, approached from another side; none: there is no room, or the side is not
// known.
Awaitable<Result<std::optional<Closure>>> RunEngine::close_from_side(ActiveRun& run,
                                                                     std::string side) {
  const auto axes = bench_.description.axes();
  std::vector<double> zero_mm(axes.size(), 0.0), aside_mm(axes.size(), 0.0);
  for (std::size_t i = 0; i < std::min(axes.size(), side.size()); ++i) {
    const char here = run.scope.sides[i];
    if (here == '?' || side[i] == here || !run.scope.moved.contains(i)) continue;
    const double away_mm = std::max(run.plan.rules.reapproach_mm, 1e-3);
    aside_mm[i] = here == '-' ? away_mm : -away_mm;
    if (aside_mm[i] < axes[i].min_mm || aside_mm[i] > axes[i].max_mm)
      co_return std::optional<Closure>{};
  }
  if (aside_mm == zero_mm || !check_keep_out(bench_.description, zero_mm, aside_mm))
    co_return std::optional<Closure>{};
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await go_to(run.scope, aside_mm, "aside of the zero"));
  Stamp measured;
  auto visiting = visit_zero_and_join(run, "zero from the other side", measured);
  DRIFTWISE_CO_TRY(const auto values, co_await std::move(visiting));
  co_return std::optional(closure_of(run, values, measured.utc));
}

Awaitable<Result<void>> RunEngine::note_closure(ActiveRun& run, std::vector<ChannelValue> values,
                                                Stamp measured, std::int64_t line) {
  auto closure = closure_of(run, values, measured.utc);
  const double largest = largest_nm(closure.lengths_nm);
  const bool has_angle = !std::ranges::all_of(closure.angles_arcsec, is_missing);
  if (is_missing(largest) && !has_angle) co_return Result<void>{};
  if (!is_missing(largest)) {
    run.progress.last_closure_nm = largest;
    bench_.events.record_own("run.closure", drift_text(run, closure.lengths_nm, largest, line),
                             run.record.id);
  }
  const auto expected = expectation(run, closure);
  auto verdict = run.closure_judge.judge(closure, expected);
  ClosureRecord record;
  record.run = run.record.id;
  record.datum = run.datum->id;
  record.line = line;
  record.measured = measured;
  record.side = side_text(bench_.description, closure.side);
  record.by = expected.by;
  record.coordinates = std::move(verdict.coordinates);
  record.sentence = std::move(verdict.sentence);
  if (verdict.good) {
    record.decision = verdict.explained ? ClosureDecision::explained : ClosureDecision::within;
    record.sentence = verdict.explained ? record.sentence + ": accept" : within_sentence(record);
  } else if (verdict.other_side) {
    auto looking = close_from_side(run, run.closure_judge.reference(closure).side);
    DRIFTWISE_CO_TRY(auto there, co_await std::move(looking));
    // By the limit of the first look, which grows with the minutes: a jump stays beyond it.
    if (there) there->at = closure.at;
    if (there && run.closure_judge.judge(*there, expectation(run, *there)).good) {
      run.closure_judge.take_play(closure, *there);
      run.closure_judge.take(closure);
      record.decision = ClosureDecision::play;
      set_play(bench_.description, closure, *there, record);
      record.sentence +=
          ": play, the zero approached from the other side is within the limit: "
          "accept";
    } else {
      record.decision = ClosureDecision::new_datum;
    }
  } else {
    record.decision = ClosureDecision::new_datum;
  }
  co_return co_await act_on(run, std::move(record), std::move(closure));
}

// Unexplained, as the cell file says it; and the record of every return.
Awaitable<Result<void>> RunEngine::act_on(ActiveRun& run, ClosureRecord record, Closure closure) {
  const auto& rules = run.closure_rules;
  record.line = line_since_return(run, record.line);
  auto& repetitions = run.repetitions[record.line];
  record.repetition = repetitions;
  if (record.decision != ClosureDecision::new_datum) {
    learn(run, closure);
    run.since_closure.close();
    auto storing = store_closure(run.scope, std::move(record), std::nullopt);
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(storing));
    run.since_return.begin(run.record.place, run.record.given_up);
    co_return Result<void>{};
  }
  const auto reason = fmt::format(
      "line {}: the zero was not found again: {} since the last good closure; look for a length "
      "that jumped, a lost fringe, something that slipped or was touched",
      record.line, record.sentence);
  if (rules.unexplained == UnexplainedClosure::repeat && repetitions < rules.repeats) {
    ++repetitions;
    record.decision = ClosureDecision::repeated;
    record.sentence +=
        fmt::format(": unexplained, repeat the line ({} of {})", repetitions, rules.repeats);
    bench_.events.record_own("closure.repeat",
                             fmt::format("{}: {}", reason, "the line is repeated"), run.record.id);
    auto line = repeat_since(run.since_return, run.record.place, run.record.given_up);
    auto storing = store_closure(run.scope, std::move(record), line);
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(storing));
    run.record.accepted -= run.since_return.accepted();
    run.record.given_up -= line.given_up;
    run.record.place = std::move(line.place);
    counted_accepted_ = std::min(counted_accepted_, run.record.accepted);
    counted_given_up_ = std::min(counted_given_up_, run.record.given_up);
    run.since_closure.drop_open();
    run.since_return.begin(run.record.place, run.record.given_up);
    wanted_datum_ = DatumOpening{"closure, the line is repeated", false, false, {}, {}};
    publish();
    co_return Result<void>{};
  }
  const auto since = run.closure_judge.last_good();
  if (rules.unexplained == UnexplainedClosure::mark) {
    record.decision = ClosureDecision::marked;
    record.sentence += ": unexplained, the line is suspect";
    bench_.events.record_own("closure.marked", reason, run.record.id);
    const auto& before = run.closure_judge.reference(closure);
    run.jumped_nm.resize(closure.lengths_nm.size(), 0.0);
    for (std::size_t i = 0; i < closure.lengths_nm.size(); ++i)
      run.jumped_nm[i] += entry(closure.lengths_nm, i) - entry(before.lengths_nm, i);
    run.closure_judge.take(closure);
  } else {
    const auto in_vain = repetitions > 0
                             ? fmt::format("the line was repeated {} times in vain; ", repetitions)
                             : std::string();
    record.sentence += fmt::format(": unexplained, {}open a new datum", in_vain);
    bench_.events.record_own("closure.bad", reason, run.record.id);
    hooks_.alarm({AlarmLevel::failed, "closure.bad", fmt::format("run {}", run.record.id.value),
                  fmt::format("run {}: {}; {}the points since then are suspect and kept out of "
                              "fits, a new datum is opened",
                              run.record.id.value, reason, in_vain)});
    // What follows counts from a zero of its own.
    wanted_datum_ = DatumOpening{"closure", false, false, {}, {}};
  }
  // Marks first: killed in between, the closure is missing and nothing is trusted too much.
  auto marking = mark_suspects(run, since, reason);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(marking));
  if (record.decision == ClosureDecision::marked) run.since_closure.close();
  auto storing = store_closure(run.scope, std::move(record), std::nullopt);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(storing));
  run.since_return.begin(run.record.place, run.record.given_up);
  co_return Result<void>{};
}

}  // namespace driftwise::application
