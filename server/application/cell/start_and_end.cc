// Start and end of a cell: the order of its parts.

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "server/application/cell/composition.h"
#include "server/core/try.h"

namespace driftwise::application {

void Composition::start() {
  if (measure_pauses_) pauses.start();
  wall_clock.start(std::move(clock_start));
  stops.start();  // a pending stop is the first thing that a controller hears
  keeper.start();
  recorder.start();
  serving.start();
  joint_serving.start();
  upkeep.start();
  access.start();
  holds.start();
  run_watch_ = engine.watchers().add([this](const RunProgress& run) {
    checks.check_after(run);
    alarms.note_progress(run);
  });
  notify.start();
  alarms.start();
  tasks.spawn(start_up());
}

Awaitable<void> Composition::start_up() {
  // Requests to move wait meanwhile: an unfinished run may have to be continued first.
  const auto lock = co_await right.turn();
  events.record_own("daemon.started",
                    fmt::format("driftwised {} on cell '{}'", version, description.name));
  events.record_own(
      configuration.changes().empty() ? "configuration.in_force" : "configuration.changed",
      configuration.event());
  const auto tell = [this](const char* what, const Result<void>& result) {
    if (!result)
      events.record_own("daemon.trouble", fmt::format("{}: {}", what, result.error().message));
  };
  tell("finding the force that acts", co_await restore_force());
  tell("finding the present datum", co_await restore_datum());
  tell("serving the promoted model", co_await restore_model());
  tell("serving the promoted plan", co_await plans.restore());
  served_again_ = true;
  looked_for_what_serves_.raise();
  co_await durations.load();  // before a run that goes on is given an end
  tell("going on with the run", co_await runs.continue_unfinished());
  alarms.note_start_is_done();
  tell("continuing the rest", co_await rests.continue_unfinished());
  queue_desk.start();
}

Awaitable<void> Composition::served_again() {
  while (!served_again_) co_await looked_for_what_serves_.wait();
}

Awaitable<Result<void>> Composition::restore_datum() {
  DRIFTWISE_CO_TRY(auto datum, co_await reader.points().newest_datum());
  if (datum) manual.take_datum(*datum);
  co_return Result<void>{};
}

// The force that a person stated last; an actuator is asked when a run needs it.
Awaitable<Result<void>> Composition::restore_force() {
  constexpr int kMost = 100'000;  // weights are changed by hand
  const auto force = description.force_channel();
  if (!force || description.load_actuator()) co_return Result<void>{};
  const auto now = clock->now().utc;
  DRIFTWISE_CO_TRY(const auto said,
                   co_await reader.readings().readings(kOperatorDevice, CellTime{0}, now, kMost));
  if (said.empty()) co_return Result<void>{};
  recorder.observe(JudgedReading{said.back(), {}});
  if (const double* force_n = said.back().find(force->name())) loading.know(*force_n);
  co_return Result<void>{};
}

Awaitable<Result<void>> Composition::restore_model() {
  DRIFTWISE_CO_TRY(auto history, co_await reader.models().promotions());
  if (history.empty() || !history.back().model) co_return Result<void>{};
  const ModelId promoted = *history.back().model;
  // Not another model in its place: targets are refused until a person promotes one.
  const auto refused = [&](const Error& error) {
    serving.refuse(promoted, error);
    return Result<void>(tl::unexpected(error));
  };
  auto record = co_await models.get(promoted);
  if (!record) co_return refused(record.error());
  if (auto ok = co_await serving.serve(std::move(*record)); !ok) co_return refused(ok.error());
  checks.served_another(true);
  co_return Result<void>{};
}

// Told first of all, while the doors still take a stop: what moves ends, long work gives way.
Awaitable<void> Composition::come_to_rest() {
  if (std::exchange(comes_to_rest_, true)) co_return;
  events.record_own("daemon.stopping", "the daemon was asked to end");
  served_again_ = true;
  looked_for_what_serves_.raise();
  const bool moves_by_hand = right.by_hand() != nullptr;
  const bool moves = engine.busy() || moves_by_hand || stops.pending();
  engine.shut_down();
  if (auto* by_hand = right.by_hand()) by_hand->shut_down();
  queue_desk.shut_down();
  improver.shut_down();
  diagnosis_desk.shut_down();
  study_desk.shut_down();
  upkeep.shut_down();
  if (!moves) co_return;
  const auto trouble = co_await rest_axes();
  if (trouble.empty() || !moves_by_hand || stops.pending()) co_return;
  // Nobody else halts what was moved by hand: the next start sends the stop before anything else.
  auto pressing =
      stops.press({"daemon", "", ""}, "the daemon ended during a movement by hand: " + trouble);
  static_cast<void>(co_await std::move(pressing));
}

// A homing ends at nothing but a stop, so the axes are stopped before anything is waited for. At
// idle they are left to whoever moves them.
Awaitable<std::string> Composition::rest_axes() {
  constexpr double kLook_s = 0.02, kSendAgain_s = 1, kPatience_s = 20;  // of wall time
  const auto wall = [this](double seconds) {
    return nanoseconds_from_s(seconds * std::max(1e-3, clock->speed()));
  };
  const auto limit = clock->now().utc + wall(kPatience_s);
  std::string trouble = "a run or a movement by hand has not ended";
  CellTime sent{};
  for (int answers = 0; clock->now().utc < limit;) {
    if (answers == 0 && clock->now().utc - sent > wall(kSendAgain_s)) {
      sent = clock->now().utc;
      if (const auto stopped = co_await bench.stop(); !stopped) trouble = stopped.error().message;
    }
    if (!engine.busy() && right.by_hand() == nullptr && !stops.pending()) {
      const auto state = co_await bench.motion_state();
      if (!state)
        trouble = state.error().message;
      else if (state->moving)
        trouble = "the axes still report motion";
      answers = state && !state->moving ? answers + 1 : 0;
      if (answers == StopDesk::kAnswers) co_return "";
    }
    co_await clock->sleep_for(wall(kLook_s));
  }
  events.record_own(
      "daemon.trouble",
      fmt::format("the controllers have not reported rest in two successive answers within "
                  "{:g} s of the end of the daemon: {}: look at the axes, use the "
                  "emergency switch where they move",
                  kPatience_s, trouble));
  co_return trouble;
}

Awaitable<void> Composition::shut_down() {
  constexpr auto kPatience =
      std::chrono::seconds(2);  // wall: then whatever is still talking is cut off
  // Wall: a fit that follows a run is not waited for; the service manager kills after 60 s.
  constexpr auto kMostPatience = std::chrono::seconds(15);
  co_await come_to_rest();
  wall_clock.shut_down();
  stops.shut_down();
  keeper.shut_down();
  pauses.shut_down();
  stop_events.shut_down();
  alarms.shut_down();
  notify.shut_down();
  recorder.shut_down();
  serving.shut_down();
  joint_serving.shut_down();
  rests.shut_down();
  access.shut_down();
  holds.shut_down();
  asio::steady_timer cut_off(executor, kPatience);
  cut_off.async_wait([this](const boost::system::error_code& error) {
    if (!error) bench.close_all();
  });
  if (!co_await tasks.all_ended_within(kMostPatience))
    spdlog::error(
        "{} tasks of the cell have not ended within {} s: the record is closed without "
        "them",
        tasks.count(), kMostPatience.count());
  cut_off.cancel();
  co_await stops.keep_for_the_next_start();
  events.shut_down();
  if (auto ok = co_await writer.flush(); !ok)
    spdlog::error("the last readings are not stored: {}", ok.error().message);
  co_await events.written();
  bench.close_all();
}

}  // namespace driftwise::application
