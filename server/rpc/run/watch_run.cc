
#include "server/application/ports/host.h"
#include "server/application/runs/runs.h"
#include "server/application/status/overview.h"
#include "server/core/reasons.h"
#include "server/rpc/run/convert_run.h"
#include "server/rpc/shared/source_task.h"
#include "server/rpc/shared/watch_sources.h"

namespace driftwise::rpc {
namespace {

using application::Host;
using application::Overview;
using application::Runs;

struct RunWatchState {  // shared with the look-up, which may end after the client has gone
  std::optional<RunId> run;
  std::optional<application::RunProgress> pending;
  std::optional<Result<void>> end;
  std::function<void()> wake;

  void take(const application::RunProgress& progress) {
    if (end) return;
    pending = progress;  // over what was not sent yet: a slow client sees the latest
    if (is_over(progress.run.state)) end = Result<void>{};
    wake();
  }
};

// The record of the run, for one that is over, and the number of the one under way.
Awaitable<void> look_up(const Overview& overview, Runs& runs,
                        std::shared_ptr<RunWatchState> state) {
  if (!state->run) {
    const auto status = overview.status();
    if (!status.run) {
      state->end = fail(ErrorCode::failed_precondition, reasons::kNoRun,
                        "no run is under way: name one, or start one");
      co_return state->wake();
    }
    state->run = status.run->run.id;
    co_return state->take(*status.run);
  }
  const auto record = co_await runs.get(*state->run);
  if (!record) {
    if (!state->end) state->end = tl::unexpected(record.error());
    co_return state->wake();
  }
  if (is_over(record->state) && !state->end) {
    application::RunProgress last;
    last.run = *record;
    last.row = record->place.next_row;
    state->take(last);
  }
}

class ProgressSource final : public StreamSource<v1::WatchRunResponse> {
 public:
  ProgressSource(const Host& host, const Overview& overview, Runs& runs, std::optional<RunId> run)
      : host_(host), overview_(overview), runs_(runs) {
    state_->run = run;
  }
  ~ProgressSource() override {
    state_->wake = [] {};
  }

  void start(std::function<void()> wake) override {
    state_->wake = std::move(wake);
    // Watching before looking: a run that ends in between is seen by one of the two.
    watch_ = runs_.watch([state = state_](const application::RunProgress& progress) {
      if (state->run && progress.run.id == *state->run) state->take(progress);
    });
    spawn_for_source(host_.executor(), look_up(overview_, runs_, state_), state_);
  }

  std::optional<v1::WatchRunResponse> next() override {
    if (!state_->pending) return std::nullopt;
    v1::WatchRunResponse response;
    *response.mutable_progress() = progress_from(*state_->pending);
    state_->pending.reset();
    return response;
  }
  std::optional<Result<void>> ended() override { return state_->end; }

 private:
  const Host& host_;
  const Overview& overview_;
  Runs& runs_;
  std::shared_ptr<RunWatchState> state_ = std::make_shared<RunWatchState>();
  std::shared_ptr<void> watch_;
};

}  // namespace

std::unique_ptr<StreamSource<v1::WatchRunResponse>> watch_run(const Host& host,
                                                              const Overview& overview, Runs& runs,
                                                              std::optional<RunId> run) {
  return std::make_unique<ProgressSource>(host, overview, runs, run);
}

}  // namespace driftwise::rpc
