// Start and end of a cell: the order of its parts.

#include <fmt/format.h>
#include <spdlog/spdlog.h>

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

Awaitable<void> Composition::shut_down() {
  constexpr auto kPatience =
      std::chrono::seconds(2);  // wall: then whatever is still talking is cut off
  events.record_own("daemon.stopping", "the daemon was asked to end");
  served_again_ = true;
  looked_for_what_serves_.raise();
  engine.shut_down();
  if (auto* by_hand = right.by_hand()) by_hand->shut_down();
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
  queue_desk.shut_down();
  rests.shut_down();
  improver.shut_down();
  diagnosis_desk.shut_down();
  study_desk.shut_down();
  upkeep.shut_down();
  access.shut_down();
  holds.shut_down();
  asio::steady_timer cut_off(executor, kPatience);
  cut_off.async_wait([this](const boost::system::error_code& error) {
    if (!error) bench.close_all();
  });
  co_await tasks.all_ended();
  cut_off.cancel();
  events.shut_down();
  if (auto ok = co_await writer.flush(); !ok)
    spdlog::error("the last readings are not stored: {}", ok.error().message);
  co_await events.written();
  bench.close_all();
}

}  // namespace driftwise::application
