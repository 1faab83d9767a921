#include "server/application/motion/zero_visit.h"

#include <fmt/format.h>

#include "server/application/motion/keep_out.h"
#include "server/application/motion/motion.h"
#include "server/application/motion/sampling_gates.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

// A little way to the side that each axis came from: a robot with play stands elsewhere when it
// comes from the other one.
std::vector<double> aside_of_zero(const RunScope& scope) {
  const auto axes = scope.bench.description.axes();
  std::vector<double> aside_mm(axes.size(), 0.0);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (!scope.moved.contains(i)) continue;
    const bool from_below = i < scope.sides.size() && scope.sides[i] == '-';
    const double away_mm = from_below ? -scope.rules.reapproach_mm : scope.rules.reapproach_mm;
    const bool has_room = away_mm >= axes[i].min_mm && away_mm <= axes[i].max_mm;
    aside_mm[i] = has_room ? away_mm : -away_mm;
  }
  return aside_mm;
}

// anew: from aside. Without room beside the zero the axes are sent there from where they are.
Awaitable<Result<Finding>> come_to_zero(RunScope& scope, const std::string& cause, bool anew) {
  const auto& cell = scope.bench.description;
  const std::vector<double> zero_mm(cell.motor_channels().size(), 0.0);
  if (anew) {
    auto aside_mm = aside_of_zero(scope);
    const bool has_room =
        check_soft_limits(cell, aside_mm) && check_keep_out(cell, zero_mm, aside_mm);
    if (has_room)
      DRIFTWISE_CO_RETURN_IF_ERROR(
          co_await go_to(scope, std::move(aside_mm), "aside of the " + cause, scope.moved));
  }
  DRIFTWISE_CO_TRY(auto arrival, co_await go_to(scope, zero_mm, cause));
  co_return Finding{arrival.trouble, std::move(arrival.sentence)};
}

Awaitable<Result<Finding>> read_at_zero(RunScope& scope, const ZeroVisit& visit,
                                        Sampling& sampling) {
  const std::vector<double> zero_mm(scope.bench.description.motor_channels().size(), 0.0);
  auto reading = take_readings(scope, scope.rules.readings_per_point, zero_mm);
  DRIFTWISE_CO_TRY(sampling, co_await std::move(reading));
  auto found =
      judge_sampling(sampling, scope.rules, visit.in_datum ? scope.bench.devices.setup() : nullptr);
  if (visit.took) visit.took(sampling);
  co_return found;
}

}  // namespace

Awaitable<Result<Sampling>> visit_zero(RunScope& scope, ZeroVisit visit) {
  AttemptTally tally{0, 0, scope.rules.max_requeues};  // a zero is not put off to the line's end
  auto before = Verdict::accepted;
  int attempts = 0;
  while (true) {
    Finding found;
    Sampling sampling;
    const bool anew = before == Verdict::reapproach;
    if (before != Verdict::reread) {
      if (anew || !visit.is_there) {
        DRIFTWISE_CO_TRY(found, co_await come_to_zero(scope, visit.cause, anew));
      }
      if (found.trouble == Trouble::none && visit.arrived) {
        auto arriving = visit.arrived();
        DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(arriving));
      }
    }
    if (found.trouble == Trouble::none) {
      DRIFTWISE_CO_TRY(found, co_await read_at_zero(scope, visit, sampling));
    }
    if (found.trouble == Trouble::none) co_return sampling;
    ++attempts;
    before = decide(found.trouble, tally, scope.rules);
    if (before != Verdict::reread && before != Verdict::reapproach)
      co_return fail(ErrorCode::failed_precondition, reasons::kZeroNotReached,
                     fmt::format("{}: {}, after {} attempt{} (max_rereads {}, max_reapproaches "
                                 "{}): look at the beam, the air around it and the servo",
                                 visit.cause, found.sentence, attempts, attempts == 1 ? "" : "s",
                                 scope.rules.max_rereads, scope.rules.max_reapproaches));
    scope.bench.events.record_own(
        "zero.again",
        fmt::format("{}: {}: {}", visit.cause, found.sentence,
                    before == Verdict::reread ? "read again" : "approached again"),
        scope.run);
    tally = after(tally, before);
  }
}

}  // namespace driftwise::application
