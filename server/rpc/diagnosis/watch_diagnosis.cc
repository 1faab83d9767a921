
#include "server/core/ports/spawn.h"
#include "server/rpc/diagnosis/convert_diagnosis.h"
#include "server/rpc/shared/watch_sources.h"

namespace driftwise::rpc {
namespace {

using application::Cell;

// The latest state of a job only: a slow client never slows whoever works. Progress has id, state;
// Record the job's end as the store has it.
template <class Id, class Progress>
struct JobWatchState {
  Id id;
  std::optional<Progress> pending;
  std::optional<Result<void>> end;
  std::function<void()> wake;

  void take(const Progress& progress) {
    if (end) return;
    pending = progress;
    if (progress.state != JobState::running) end = Result<void>{};
    wake();
  }
  void refuse(const Error& error) {
    if (!end) end = tl::unexpected(error);
    wake();
  }
};

using DiagnosisWatch = JobWatchState<DiagnosisId, application::DiagnosisProgress>;
using ImprovementWatch = JobWatchState<ImprovementId, application::ImprovementProgress>;

// One that is over is told as it ended; one under way as well, should nobody have told yet.
Awaitable<void> look_up_diagnosis(Cell& cell, std::shared_ptr<DiagnosisWatch> state) {
  const auto view = co_await cell.diagnosis(state->id);
  if (!view) co_return state->refuse(view.error());
  const auto& record = view->record;
  if (record.state != JobState::running)
    state->take({record.id, record.state,
                 record.state == JobState::done ? std::string("done") : record.reason,
                 record.state == JobState::done ? 1.0 : 0.0});
  else if (!state->pending && !state->end)
    state->take({record.id, record.state, "", 0});
}

Awaitable<void> look_up_improvement(Cell& cell, std::shared_ptr<ImprovementWatch> state) {
  const auto record = co_await cell.improvement(state->id);
  if (!record) co_return state->refuse(record.error());
  const int turns = static_cast<int>(record->turns.size());
  if (record->state != JobState::running)
    state->take({record->id, record->state, turns, record->reason});
  else if (!state->pending && !state->end)
    state->take({record->id, record->state, turns, ""});
}

class DiagnosisSource final : public StreamSource<v1::WatchDiagnosisResponse> {
 public:
  DiagnosisSource(Cell& cell, DiagnosisId id) : cell_(cell) { state_->id = id; }
  ~DiagnosisSource() override {
    state_->wake = [] {};
  }
  void start(std::function<void()> wake) override {
    state_->wake = std::move(wake);
    // Watching before looking: one that ends in between is seen by one of the two.
    watch_ =
        cell_.watch_diagnoses([state = state_](const application::DiagnosisProgress& progress) {
          if (progress.id == state->id) state->take(progress);
        });
    spawn(cell_.executor(), look_up_diagnosis(cell_, state_));
  }
  std::optional<v1::WatchDiagnosisResponse> next() override {
    if (!state_->pending) return std::nullopt;
    v1::WatchDiagnosisResponse response;
    *response.mutable_progress() = diagnosis_progress_from(*state_->pending);
    state_->pending.reset();
    return response;
  }
  std::optional<Result<void>> ended() override { return state_->end; }

 private:
  Cell& cell_;
  std::shared_ptr<DiagnosisWatch> state_ = std::make_shared<DiagnosisWatch>();
  Cell::Watch watch_;
};

class ImprovementSource final : public StreamSource<v1::WatchImprovementResponse> {
 public:
  ImprovementSource(Cell& cell, ImprovementId id) : cell_(cell) { state_->id = id; }
  ~ImprovementSource() override {
    state_->wake = [] {};
  }
  void start(std::function<void()> wake) override {
    state_->wake = std::move(wake);
    watch_ = cell_.watch_improvements(
        [state = state_](const application::ImprovementProgress& progress) {
          if (progress.id == state->id) state->take(progress);
        });
    spawn(cell_.executor(), look_up_improvement(cell_, state_));
  }
  std::optional<v1::WatchImprovementResponse> next() override {
    if (!state_->pending) return std::nullopt;
    v1::WatchImprovementResponse response;
    *response.mutable_progress() = improvement_progress_from(*state_->pending);
    state_->pending.reset();
    return response;
  }
  std::optional<Result<void>> ended() override { return state_->end; }

 private:
  Cell& cell_;
  std::shared_ptr<ImprovementWatch> state_ = std::make_shared<ImprovementWatch>();
  Cell::Watch watch_;
};

}  // namespace

std::unique_ptr<StreamSource<v1::WatchDiagnosisResponse>> watch_diagnosis(Cell& cell,
                                                                          DiagnosisId id) {
  return std::make_unique<DiagnosisSource>(cell, id);
}

std::unique_ptr<StreamSource<v1::WatchImprovementResponse>> watch_improvement(Cell& cell,
                                                                              ImprovementId id) {
  return std::make_unique<ImprovementSource>(cell, id);
}

}  // namespace driftwise::rpc
