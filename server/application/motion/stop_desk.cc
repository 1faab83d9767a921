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
                     [](const Place& place) { return place.stop && !place.is_confirmed(); });
}

bool StopDesk::is_over() const {
  return std::none_of(places_.begin(), places_.end(),
                      [](const Place& place) { return place.stop.has_value(); });
}

std::optional<StopRecord> StopDesk::unstored() const {
  for (const auto& place : places_)
    if (place.stop && !place.stored) return place.stop;
  return std::nullopt;
}

bool StopDesk::all_stored() const {
  return std::all_of(places_.begin(), places_.end(),
                     [](const Place& place) { return !place.stop || place.stored; });
}

std::vector<StopRecord> StopDesk::records() const {
  std::vector<StopRecord> records;
  for (const auto& place : places_)
    if (place.stop && !place.is_confirmed()) records.push_back(*place.stop);
  return records;
}

Nanoseconds StopDesk::of_wall(milliseconds wall) const {
  return nanoseconds_from_s(0.001 * static_cast<double>(wall.count()) * clock_.speed());
}

std::string StopDesk::sentence(const Place& place) const {
  const double age_s = seconds_from(clock_.now().utc - place.stop->asked.utc);
  if (place.is_confirmed())
    return fmt::format(
        "{} {:.1f} s ago: {} reports no motion, but the stop is not on record yet{}{}. It is "
        "written again until it is; no motion is accepted before",
        place.stop->cause, age_s, place.controller.id, refusal_.empty() ? "" : ": ", refusal_);
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
    if (place.stop && place.late && !place.is_confirmed())
      out.push_back({place.controller.id, sentence(place)});
  return out;
}

StopAnswer StopDesk::answer() const {
  StopAnswer answer;
  answer.pending = records();
  answer.confirmed = answer.pending.empty();
  std::string ids;
  for (const auto& place : places_) {
    ids += (ids.empty() ? "" : ", ") + place.controller.id;
    if (place.stop && !place.is_confirmed() && answer.message.empty())
      answer.message = sentence(place);
  }
  if (!answer.confirmed) return answer;
  answer.message = ids.empty() ? "this cell has no motion controller"
                               : fmt::format("{}: no motion, in two successive answers", ids);
  if (!all_stored() && !refusal_.empty())
    answer.message += fmt::format(
        "; the stop is not on record yet: {}; it is written again until it is, no motion is "
        "accepted before",
        refusal_);
  return answer;
}

Awaitable<StopAnswer> StopDesk::press(Caller caller, std::string cause,
                                      std::optional<CellTime> held_at) {
  const auto now = clock_.now();
  if (on_press_) on_press_(caller, cause);
  for (auto& place : places_) {
    if (place.stop) {
      ++place.stop->presses;
      place.stop->cause = cause;
      if (place.is_confirmed()) place.late = false;
      place.stop->confirmed = {};
    } else {
      place.stop =
          StopRecord{{}, place.controller.id, caller.name, caller.peer, cause, now, 1, {}, {}, {}};
      place.late = false;
      place.trouble.clear();
    }
    place.stop->held_by = caller.name;
    place.stop->held_at = held_at.value_or(now.utc);
    place.stored = false;
  }
  keep_soon();
  const auto send_by = now.utc + of_wall(kSendWithin), answer_by = now.utc + of_wall(kAnswerWithin);
  while (!all_stored() && keeping_ && !ending_ && clock_.now().utc < send_by)
    co_await sleep_unless(clock_, send_by, changed_);
  pressed_.raise();
  for (auto& place : places_)
    if (place.stop) begin_confirming(place);
  while (!is_over() && !ending_ && clock_.now().utc < answer_by)
    co_await sleep_unless(clock_, answer_by, changed_);
  for (auto& place : places_)
    if (place.stop && !place.is_confirmed() && !std::exchange(place.late, true))
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

// One write is under way at most, and one waits that all further presses share.
void StopDesk::keep_soon() {
  keep_again_ = true;
  if (!std::exchange(keeping_, true)) tasks_.spawn(keep_while_asked());
}

Awaitable<void> StopDesk::keep_while_asked() {
  while (std::exchange(keep_again_, false)) co_await keep();
  keeping_ = false;
  changed_.raise();
}

Awaitable<void> StopDesk::keep() {
  std::vector<StopRecord> stops;
  for (const auto& place : places_)
    if (place.stop && !place.stored) stops.push_back(*place.stop);
  if (stops.empty()) co_return;
  const auto stored = co_await writer_.stops().keep(stops);
  refusal_ = stored ? std::string() : stored.error().message;
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
    if (!place.stored) keep_soon();  // the disk was full or slow
    if (place.is_confirmed()) {
      co_await end(place);
    } else {
      const auto sent = co_await place.controller.stop();
      if (!sent) place.trouble = sent.error().message;
      bool rests = false;
      if (sent) rests = co_await at_rest(place);
      if (rests && place.stop->presses == presses) {
        note_rest(place);
        pause_s = kFirstPause_s;
        continue;
      }
    }
    if (ending_ || !place.stop || place.stop->presses != presses) continue;
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

void StopDesk::note_rest(Place& place) {
  const auto& stop = *place.stop;
  const auto now = clock_.now().utc;
  place.stop->confirmed = now;
  if (place.late)  // else the record of the stop says enough
    events_.record_own(
        "stop.confirmed",
        fmt::format("{}: {} reports no motion, {:.2f} s after the first of {} request{}",
                    stop.cause, place.controller.id, seconds_from(now - stop.asked.utc),
                    stop.presses, stop.presses == 1 ? "" : "s"));
  changed_.raise();
}

// Over when it is on record that it was asked for and that it is confirmed. What is not on record
// would be forgotten by the next start, which would let the queue begin.
Awaitable<void> StopDesk::end(Place& place) {
  const auto presses = place.stop->presses;
  while (keeping_ && !ending_) co_await changed_.wait();
  if (!place.stored || place.stop->presses != presses || ending_) co_return;
  const StopRecord stop = *place.stop;
  const auto stored = co_await writer_.stops().confirm(stop, stop.confirmed);
  if (place.stop->presses != presses) co_return;  // pressed again meanwhile
  if (!stored) {
    refusal_ = stored.error().message;
    co_return;
  }
  place.stop.reset();
  if (is_over()) co_await end_orphans();
  changed_.raise();
}

Awaitable<void> StopDesk::keep_for_the_next_start() { return keep(); }

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
