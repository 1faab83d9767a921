#include "server/application/motion/stop_desk.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/application/plumbing/task_group.h"
#include "server/core/reasons.h"

namespace driftwise::application {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kSendWithin{40}, kAnswerWithin{80};  // of wall time
constexpr double kBetweenAnswers_s = 0.02;
// A controller that still reports motion after this long is told to stop again.
constexpr double kSendAgain_s = 1;
constexpr double kFirstPause_s = 0.1, kLongestPause_s = 1;
constexpr milliseconds kLeastPause{50};  // of wall time, however fast the cell's clock runs

}  // namespace

StopDesk::StopDesk(asio::any_io_executor executor, Clock& clock, StoreWriter& writer,
                   EventLog& events, TaskGroup& tasks, std::vector<Controller> controllers)
    : executor_(executor),
      clock_(clock),
      writer_(writer),
      events_(events),
      tasks_(tasks),
      changed_(executor),
      pressed_(executor) {
  for (auto& controller : controllers) {
    places_.emplace_back();
    places_.back().controller = std::move(controller);
  }
}

void StopDesk::restore(std::vector<StopRecord> pending) {
  const auto take = [](Place& place, StopRecord stop) {
    stop.controller = place.controller.id;
    place.stop = std::move(stop);
    place.late = true;  // the answer to whoever asked for it is long over
    place.trouble = "the daemon was started anew";
  };
  if (!pending.empty()) cause_at_start_ = pending.front().cause;
  for (auto& stop : pending) {
    const auto known = std::find_if(places_.begin(), places_.end(), [&](const Place& place) {
      return place.controller.id == stop.controller;
    });
    if (known != places_.end()) {
      take(*known, stop);
      known->stored = true;
      continue;
    }
    for (auto& place : places_)
      if (!place.stop) take(place, stop);
    orphans_.push_back(std::move(stop));
  }
}

void StopDesk::start() {
  for (auto& place : places_) {
    if (!place.stop) continue;
    events_.record_own("stop.pending", sentence(place));
    begin_confirming(place);
  }
}

void StopDesk::shut_down() {
  ending_ = true;
  changed_.raise();
  pressed_.raise();
}

bool StopDesk::pending() const {
  return std::any_of(places_.begin(), places_.end(),
                     [](const Place& place) { return place.stop.has_value(); });
}

bool StopDesk::all_stored() const {
  return std::all_of(places_.begin(), places_.end(),
                     [](const Place& place) { return !place.stop || place.stored; });
}

std::vector<StopRecord> StopDesk::records() const {
  std::vector<StopRecord> records;
  for (const auto& place : places_)
    if (place.stop) records.push_back(*place.stop);
  return records;
}

Nanoseconds StopDesk::of_wall(milliseconds wall) const {
  return nanoseconds_from_s(0.001 * static_cast<double>(wall.count()) * clock_.speed());
}

std::string StopDesk::sentence(const Place& place) const {
  const double age_s = seconds_from(clock_.now().utc - place.stop->asked.utc);
  return fmt::format(
      "{} {:.1f} s ago, not confirmed: use the emergency switch. {} has not reported no motion in "
      "two successive answers{}{}. The stop is sent again until it has; no motion is accepted "
      "before",
      place.stop->cause, age_s, place.controller.id, place.trouble.empty() ? "" : ": ",
      place.trouble);
}

Result<void> StopDesk::check() const {
  for (const auto& place : places_)
    if (place.stop)
      return fail(ErrorCode::failed_precondition, reasons::kStopPending, sentence(place));
  return {};
}

std::vector<StopDesk::Unconfirmed> StopDesk::unconfirmed() const {
  std::vector<Unconfirmed> out;
  for (const auto& place : places_)
    if (place.stop && place.late) out.push_back({place.controller.id, sentence(place)});
  return out;
}

StopAnswer StopDesk::answer() const {
  StopAnswer answer;
  answer.pending = records();
  answer.confirmed = answer.pending.empty();
  std::string ids;
  for (const auto& place : places_) {
    ids += (ids.empty() ? "" : ", ") + place.controller.id;
    if (place.stop && answer.message.empty()) answer.message = sentence(place);
  }
  if (answer.confirmed)
    answer.message = ids.empty() ? "this cell has no motion controller"
                                 : fmt::format("{}: no motion, in two successive answers", ids);
  return answer;
}

Awaitable<StopAnswer> StopDesk::press(Caller caller, std::string cause) {
  const auto now = clock_.now();
  if (on_press_) on_press_(caller, cause);
  for (auto& place : places_) {
    if (place.stop) {
      ++place.stop->presses;
      place.stop->cause = cause;
    } else {
      place.stop = StopRecord{{}, place.controller.id, caller.name, caller.peer, cause, now, 1, {}};
      place.late = false;
      place.trouble.clear();
    }
    place.stored = false;
  }
  tasks_.spawn(keep());
  const auto send_by = now.utc + of_wall(kSendWithin), answer_by = now.utc + of_wall(kAnswerWithin);
  while (!all_stored() && !ending_ && clock_.now().utc < send_by)
    co_await sleep_unless(clock_, send_by, changed_);
  pressed_.raise();
  for (auto& place : places_)
    if (place.stop) begin_confirming(place);
  while (pending() && !ending_ && clock_.now().utc < answer_by)
    co_await sleep_unless(clock_, answer_by, changed_);
  for (auto& place : places_)
    if (place.stop && !std::exchange(place.late, true))
      events_.record_own("stop.unconfirmed", sentence(place));
  co_return answer();
}

// One task per controller confirms; a further press while it works is sent at once beside it.
void StopDesk::begin_confirming(Place& place) {
  tasks_.spawn(std::exchange(place.confirming, true) ? send(place) : confirm(place));
}

Awaitable<void> StopDesk::send(Place& place) {
  static_cast<void>(co_await place.controller.stop());
}

Awaitable<void> StopDesk::keep() {
  std::vector<StopRecord> stops = records();
  const auto stored = co_await writer_.stops().keep(stops);
  for (auto& place : places_)
    for (const auto& stop : stops)
      if (stored && place.stop && stop.controller == place.controller.id &&
          stop.presses == place.stop->presses)
        place.stored = true;
  changed_.raise();
}

Awaitable<void> StopDesk::confirm(Place& place) {
  double pause_s = kFirstPause_s;
  while (place.stop && !ending_) {
    const auto presses = place.stop->presses;
    if (!place.stored) {  // the disk was full or slow
      tasks_.spawn(keep());
    }
    const auto sent = co_await place.controller.stop();
    if (!sent) place.trouble = sent.error().message;
    bool rests = false;
    if (sent) rests = co_await at_rest(place);
    if (rests && place.stop->presses == presses) {
      co_await end(place);
      continue;
    }
    if (ending_ || place.stop->presses != presses) continue;
    const auto pause = std::max(nanoseconds_from_s(pause_s), of_wall(kLeastPause));
    co_await sleep_unless(clock_, clock_.now().utc + pause, pressed_);
    pause_s = std::min(kLongestPause_s, 2 * pause_s);
  }
  place.confirming = false;
}

// True: no motion in two successive answers. False: it could not be asked, or moves for so long
// that it is told again.
Awaitable<bool> StopDesk::at_rest(Place& place) {
  const auto limit = clock_.now().utc + nanoseconds_from_s(kSendAgain_s);
  const auto presses = place.stop->presses;
  int answers = 0;
  while (!ending_ && place.stop->presses == presses) {
    const auto state = co_await place.controller.state();
    if (!state) {
      place.trouble = state.error().message;
      co_return false;
    }
    answers = state->moving ? 0 : answers + 1;
    if (answers == kAnswers) co_return true;
    if (state->moving) place.trouble = "it still reports motion";
    if (clock_.now().utc > limit) co_return false;
    co_await clock_.sleep_for(nanoseconds_from_s(kBetweenAnswers_s));
  }
  co_return false;
}

Awaitable<void> StopDesk::end(Place& place) {
  const StopRecord stop = *place.stop;
  const auto now = clock_.now();
  const auto stored = co_await writer_.stops().confirm(stop, now.utc);
  if (place.stop->presses != stop.presses) co_return;  // pressed again meanwhile
  if (!stored)  // a restart sends the stop once more, to an axis that rests
    events_.record_own("daemon.trouble",
                       "storing that a stop is confirmed: " + stored.error().message);
  if (place.late)  // else the record of the stop says enough
    events_.record_own(
        "stop.confirmed",
        fmt::format("{}: {} reports no motion, {:.2f} s after the first of {} request{}",
                    stop.cause, place.controller.id, seconds_from(now.utc - stop.asked.utc),
                    stop.presses, stop.presses == 1 ? "" : "s"));
  place.stop.reset();
  if (!pending()) co_await end_orphans();
  changed_.raise();
}

Awaitable<void> StopDesk::end_orphans() {
  if (orphans_.empty()) co_return;
  const auto orphans = std::exchange(orphans_, {});
  co_await writer_.call(
      [at = clock_.now().utc](Store& store, const std::vector<StopRecord>& stops) {
        for (const auto& stop : stops) static_cast<void>(store.stops().confirm(stop, at));
      },
      orphans);
}

}  // namespace driftwise::application
