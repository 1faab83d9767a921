#include "server/application/improvement/improver.h"

#include <fmt/format.h>

#include <utility>

#include "server/application/plumbing/task_group.h"
#include "server/core/reasons.h"
#include "server/core/records/state_text.h"

namespace driftwise::application {

namespace {

constexpr double kEndAgain_s = 5;  // of cell time

}  // namespace

struct Improver::Active {
  explicit Active(const asio::any_io_executor& executor) : changed(executor) {}
  ImprovementRecord record;
  ImprovementProgress progress;
  std::unique_ptr<ImprovementLoop> loop;
  bool over = false;    // how it ends is decided
  bool closed = false;  // and on disk, or the daemon ends before the disk takes it
  std::string refused;  // why the end is not on disk yet
  Signal changed;
};

Improver::Improver(asio::any_io_executor executor, ImprovementServices services, Clock& clock,
                   StoreWriter& writer, EventLog& events, TaskGroup& tasks)
    : executor_(executor),
      services_(services),
      clock_(clock),
      writer_(writer),
      events_(events),
      tasks_(tasks) {}

Improver::~Improver() = default;

Awaitable<Result<ImprovementRecord>> Improver::begin(Caller caller, ImproveRequest request,
                                                     std::string formula) {
  if (active_ && !request.request_id.empty() && active_->record.request_id == request.request_id)
    co_return active_->record;
  if (ending_)
    co_return fail(ErrorCode::cancelled, reasons::kShuttingDown, "the daemon is shutting down");
  if (active_ || beginning_)
    co_return fail(ErrorCode::failed_precondition, reasons::kImprovementUnderWay,
                   active_ ? fmt::format("improvement {} is under way: cancel it, or wait for it",
                                         active_->record.id.value)
                           : std::string("an improvement is about to begin"));
  ImprovementRecord fresh;
  fresh.trajectory_name = request.trajectory_name;
  fresh.trajectory_text = request.trajectory_text;
  fresh.formula = std::move(formula);
  fresh.max_turns = request.max_turns;
  fresh.budget_s = request.budget_s;
  fresh.promotes = request.promotes;
  fresh.request_id = request.request_id;
  fresh.created = clock_.now().utc;
  fresh.created_by = caller.name;
  beginning_ = true;
  auto stored = co_await writer_.improvements().add_improvement(fresh);
  beginning_ = false;
  if (!stored || stored->created != fresh.created) co_return stored;  // failed, or a repeat
  events_.record(
      caller, "improvement.started",
      fmt::format("{} began improvement {}: {}", caller.name, stored->id.value, stored->formula));
  auto active = std::make_shared<Active>(executor_);
  active->record = *stored;
  active->progress.id = stored->id;
  active->progress.step = "beginning";
  ImprovementLoop::Hooks hooks;
  hooks.tell = [this, one = active.get()](int turn, const std::string& step) {
    if (one->over) return;
    one->progress.turn = turn;
    one->progress.step = step;
    watchers_.publish(one->progress);
  };
  hooks.keep = [this, id = stored->id](ImprovementTurn turn) {
    return writer_.improvements().put_turn(id, turn);
  };
  active->loop = std::make_unique<ImprovementLoop>(
      executor_, services_, clock_, caller, std::move(request), stored->id, std::move(hooks));
  active_ = active;
  tasks_.spawn(carry_out(std::move(active)));
  co_return stored;
}

Awaitable<void> Improver::carry_out(std::shared_ptr<Active> active) {
  watchers_.publish(active->progress);
  const auto reason = co_await active->loop->carry_out();
  auto text = reason ? *reason : reason.error().message;
  if (!std::exchange(active->over, true)) {
    auto ending = end(active, reason ? JobState::done : JobState::failed, std::move(text));
    static_cast<void>(co_await std::move(ending));
  }
  while (!active->closed) co_await active->changed.wait();
  if (active_ == active) active_.reset();
}

Awaitable<Result<void>> Improver::end(std::shared_ptr<Active> active, JobState state,
                                      std::string reason) {
  auto withdrawing = active->loop->withdraw();
  const std::string withdrawn = co_await std::move(withdrawing);
  if (!withdrawn.empty()) reason += "; " + withdrawn;
  active->progress.step = reason;
  const CellTime at = clock_.now().utc;
  auto stored =
      co_await writer_.improvements().end_improvement(active->record.id, state, reason, at);
  if (stored || ending_) {
    close(*active, state, stored ? std::string() : stored.error().message);
    co_return stored;
  }
  active->refused = stored.error().message;
  events_.record_own(
      "improvement.trouble",
      fmt::format("improvement {} {}, but the database does not take it: {}. It is tried again "
                  "every {:g} s until the database does, or the daemon ends",
                  active->record.id.value, is_text(state), active->refused, kEndAgain_s));
  watchers_.publish(active->progress);
  tasks_.spawn(store_later(std::move(active), state, std::move(reason), at));
  co_return stored;
}

// The record says 'running' until then, and whoever waits for the improvement reads the record.
Awaitable<void> Improver::store_later(std::shared_ptr<Active> active, JobState state,
                                      std::string reason, CellTime at) {
  while (!active->refused.empty()) {
    const auto due = clock_.now().utc + nanoseconds_from_s(kEndAgain_s);
    while (clock_.now().utc < due && !ending_) co_await sleep_unless(clock_, due, active->changed);
    const auto stored =
        co_await writer_.improvements().end_improvement(active->record.id, state, reason, at);
    const bool is_stored = stored || stored.error().reason == reasons::kAlreadyOver;
    active->refused = is_stored ? std::string() : stored.error().message;
    if (ending_) break;
  }
  close(*active, state, active->refused);
}

// refused: why the database does not have it where the daemon ends before; the start after this one
// finds it unfinished.
void Improver::close(Active& active, JobState state, const std::string& refused) {
  active.closed = true;
  active.progress.state = state;
  events_.record_own(fmt::format("improvement.{}", to_string(state)),
                     fmt::format("improvement {} {}: {}", active.record.id.value, is_text(state),
                                 refused.empty() ? active.progress.step : refused));
  watchers_.publish(active.progress);
  active.changed.raise();
}

Awaitable<Result<void>> Improver::cancel(Caller caller, ImprovementId id) {
  const auto active = active_;
  if (!active || active->record.id != id) co_return Result<void>{};
  if (active->over && !active->refused.empty())
    co_return fail(ErrorCode::resource_exhausted, reasons::kDiskFull,
                   fmt::format("improvement {} is over and nothing is left to cancel, but the "
                               "database does not take its end: {}. It is tried again by itself",
                               id.value, active->refused));
  if (active->over) co_return Result<void>{};
  auto stopping =
      stop_and_end(active, false, JobState::cancelled, fmt::format("cancelled by {}", caller.name));
  co_return co_await std::move(stopping);
}

Awaitable<Result<void>> Improver::stop_and_end(std::shared_ptr<Active> active, bool leave_run,
                                               JobState state, std::string reason) {
  if (std::exchange(active->over, true)) co_return Result<void>{};
  auto stopping = active->loop->stop(leave_run);
  co_await std::move(stopping);
  auto ending = end(std::move(active), state, std::move(reason));
  co_return co_await std::move(ending);
}

Awaitable<void> Improver::stop(std::shared_ptr<Active> active, std::string reason) {
  auto stopping = stop_and_end(std::move(active), true, JobState::failed, std::move(reason));
  static_cast<void>(co_await std::move(stopping));
}

void Improver::tell_present(const std::function<void(const ImprovementProgress&)>& to) const {
  if (active_) to(active_->progress);
}

void Improver::shut_down() {
  ending_ = true;
  if (!active_) return;
  active_->changed.raise();  // an end that waits for the disk is tried once more
  tasks_.spawn(stop(active_, "the daemon was stopped while it ran; its runs stay"));
}

void Improver::halt(const std::string& why) {
  if (!active_ || active_->over) return;
  tasks_.spawn(
      stop(active_, why + ": an improvement does not continue after a stop; its runs stay"));
}

}  // namespace driftwise::application
