
#include "server/application/diagnoses/diagnoses.h"
#include "server/application/improvement/improvements.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/ports/host.h"
#include "server/rpc/diagnosis/convert_diagnosis.h"
#include "server/rpc/shared/source_task.h"
#include "server/rpc/shared/watch_sources.h"

namespace driftwise::rpc {
namespace {

using application::Diagnoses;
using application::Host;
using application::Improvements;
using application::StoreReader;

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
Awaitable<void> look_up_diagnosis(Diagnoses& diagnoses, std::shared_ptr<DiagnosisWatch> state) {
  const auto view = co_await diagnoses.get(state->id);
  if (!view) co_return state->refuse(view.error());
  const auto& record = view->record;
  if (record.state != JobState::running)
    state->take({record.id, record.state,
                 record.state == JobState::done ? std::string("done") : record.reason,
                 record.state == JobState::done ? 1.0 : 0.0});
  else if (!state->pending && !state->end)
    state->take({record.id, record.state, "", 0});
}

Awaitable<void> look_up_improvement(StoreReader& records, std::shared_ptr<ImprovementWatch> state) {
  const auto record = co_await records.improvements().improvement(state->id);
  if (!record) co_return state->refuse(record.error());
  const int turns = static_cast<int>(record->turns.size());
  if (record->state != JobState::running)
    state->take({record->id, record->state, turns, record->reason});
  else if (!state->pending && !state->end)
    state->take({record->id, record->state, turns, ""});
}

class DiagnosisSource final : public StreamSource<v1::WatchDiagnosisResponse> {
 public:
  DiagnosisSource(const Host& host, Diagnoses& diagnoses, DiagnosisId id)
      : host_(host), diagnoses_(diagnoses) {
    state_->id = id;
  }
  ~DiagnosisSource() override {
    state_->wake = [] {};
  }
  void start(std::function<void()> wake) override {
    state_->wake = std::move(wake);
    // Watching before looking: one that ends in between is seen by one of the two.
    watch_ = diagnoses_.watch([state = state_](const application::DiagnosisProgress& progress) {
      if (progress.id == state->id) state->take(progress);
    });
    spawn_for_source(host_.executor(), look_up_diagnosis(diagnoses_, state_), state_);
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
  const Host& host_;
  Diagnoses& diagnoses_;
  std::shared_ptr<DiagnosisWatch> state_ = std::make_shared<DiagnosisWatch>();
  std::shared_ptr<void> watch_;
};

class ImprovementSource final : public StreamSource<v1::WatchImprovementResponse> {
 public:
  ImprovementSource(const Host& host, Improvements& improvements, StoreReader& records,
                    ImprovementId id)
      : host_(host), improvements_(improvements), records_(records) {
    state_->id = id;
  }
  ~ImprovementSource() override {
    state_->wake = [] {};
  }
  void start(std::function<void()> wake) override {
    state_->wake = std::move(wake);
    watch_ =
        improvements_.watch([state = state_](const application::ImprovementProgress& progress) {
          if (progress.id == state->id) state->take(progress);
        });
    spawn_for_source(host_.executor(), look_up_improvement(records_, state_), state_);
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
  const Host& host_;
  Improvements& improvements_;
  StoreReader& records_;
  std::shared_ptr<ImprovementWatch> state_ = std::make_shared<ImprovementWatch>();
  std::shared_ptr<void> watch_;
};

}  // namespace

std::unique_ptr<StreamSource<v1::WatchDiagnosisResponse>> watch_diagnosis(const Host& host,
                                                                          Diagnoses& diagnoses,
                                                                          DiagnosisId id) {
  return std::make_unique<DiagnosisSource>(host, diagnoses, id);
}

std::unique_ptr<StreamSource<v1::WatchImprovementResponse>> watch_improvement(
    const Host& host, Improvements& improvements, StoreReader& records, ImprovementId id) {
  return std::make_unique<ImprovementSource>(host, improvements, records, id);
}

}  // namespace driftwise::rpc
