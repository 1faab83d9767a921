#include "server/application/improvement/improver.h"

#include <fmt/format.h>

#include <utility>

#include "server/application/plumbing/task_group.h"
#include "server/core/reasons.h"
#include "server/core/records/state_text.h"

namespace driftwise::application {

struct Improver::Active {
  ImprovementRecord record;
  ImprovementProgress progress;
  std::unique_ptr<ImprovementLoop> loop;
  bool over = false;  // how it ends is decided
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
  auto active = std::make_shared<Active>();
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
  if (active_ == active) active_.reset();
}

Awaitable<Result<void>> Improver::end(std::shared_ptr<Active> active, JobState state,
                                      std::string reason) {
  auto withdrawing = active->loop->withdraw();
  const std::string withdrawn = co_await std::move(withdrawing);
  if (!withdrawn.empty()) reason += "; " + withdrawn;
  auto stored = co_await writer_.improvements().end_improvement(active->record.id, state, reason,
                                                                clock_.now().utc);
  auto detail = fmt::format("improvement {} {}: {}", active->record.id.value, is_text(state),
                            stored ? reason : stored.error().message);
  events_.record_own(fmt::format("improvement.{}", to_string(state)), std::move(detail));
  active->progress.state = state;
  active->progress.step = reason;
  watchers_.publish(active->progress);
  co_return stored;
}

Awaitable<Result<void>> Improver::cancel(Caller caller, ImprovementId id) {
  const auto active = active_;
  if (!active || active->record.id != id || active->over) co_return Result<void>{};
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
  tasks_.spawn(stop(active_, "the daemon was stopped while it ran; its runs stay"));
}

void Improver::halt(const std::string& why) {
  if (!active_ || active_->over) return;
  tasks_.spawn(
      stop(active_, why + ": an improvement does not continue after a stop; its runs stay"));
}

}  // namespace driftwise::application
