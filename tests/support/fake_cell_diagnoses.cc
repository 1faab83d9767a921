#include "server/core/try.h"
#include "tests/support/fake_cell.h"

namespace driftwise::tests {

Result<app::DiagnosisView*> FakeCell::find_diagnosis(DiagnosisId id) {
  for (auto& view : the_diagnoses)
    if (view.record.id == id) return &view;
  return fail(ErrorCode::not_found, "NO_SUCH_DIAGNOSIS",
              "there is no diagnosis " + std::to_string(id.value));
}

Awaitable<Result<app::DiagnosisView>> FakeCell::create_diagnosis(app::Caller caller,
                                                                 app::DiagnosisRequest request) {
  last_caller = caller;
  last_diagnosis = request;
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  app::DiagnosisView view;
  view.record.id = {static_cast<std::int64_t>(the_diagnoses.size()) + 1};
  view.record.runs = request.runs;
  view.record.baseline = request.baseline;
  view.record.created_by = caller.name;
  view.record.created = the_time;
  the_diagnoses.push_back(view);
  co_return view;
}

Awaitable<Result<app::DiagnosisView>> FakeCell::diagnosis(DiagnosisId id) {
  DRIFTWISE_CO_TRY(const auto found, find_diagnosis(id));
  co_return *found;
}

Awaitable<Result<formats::DiscrepancyRows>> FakeCell::diagnosis_rows(DiagnosisId id) {
  DRIFTWISE_CO_RETURN_IF_ERROR(find_diagnosis(id));
  co_return the_rows;
}

Awaitable<Result<std::vector<app::DiagnosisView>>> FakeCell::diagnoses() {
  co_return std::vector<app::DiagnosisView>(the_diagnoses.rbegin(), the_diagnoses.rend());
}

Awaitable<Result<app::DiagnosisView>> FakeCell::cancel_diagnosis(app::Caller caller,
                                                                 DiagnosisId id) {
  last_caller = caller;
  DRIFTWISE_CO_TRY(const auto found, find_diagnosis(id));
  found->record.state = JobState::cancelled;
  found->record.reason = "cancelled by " + caller.name;
  publish_diagnosis({id, JobState::cancelled, found->record.reason, 0});
  co_return *found;
}

Awaitable<Result<ExtensionRecord>> FakeCell::accept_extension(app::Caller caller,
                                                              app::AcceptRequest request) {
  last_caller = caller;
  last_accept = request;
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  DRIFTWISE_CO_TRY(const auto found, find_diagnosis(request.diagnosis));
  ExtensionRecord made;
  made.diagnosis = request.diagnosis;
  made.findings = request.findings.empty() ? std::vector<int>{1} : request.findings;
  made.model = ModelId{7};
  made.promoted = request.promote;
  made.accepted = the_time;
  made.accepted_by = caller.name;
  found->extension = made;
  co_return made;
}

Awaitable<Result<ExtensionRecord>> FakeCell::undo_extension(app::Caller caller, DiagnosisId id) {
  last_caller = caller;
  DRIFTWISE_CO_TRY(const auto found, find_diagnosis(id));
  if (!found->extension)
    co_return fail(ErrorCode::failed_precondition, "NO_EXTENSION", "nothing was accepted");
  found->extension->undone = the_time;
  found->extension->undone_by = caller.name;
  co_return *found->extension;
}

Awaitable<Result<ImprovementRecord>> FakeCell::create_improvement(app::Caller caller,
                                                                  app::ImproveRequest request) {
  last_caller = caller;
  last_improve = request;
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  DRIFTWISE_CO_RETURN_IF_ERROR(check_lease(request.lease_token));
  ImprovementRecord record;
  record.id = {static_cast<std::int64_t>(the_improvements.size()) + 1};
  record.trajectory_name = request.trajectory_name;
  record.formula = request.formula;
  record.max_turns = request.max_turns;
  record.created = the_time;
  record.created_by = caller.name;
  the_improvements.push_back(record);
  co_return record;
}

Awaitable<Result<ImprovementRecord>> FakeCell::improvement(ImprovementId id) {
  for (const auto& record : the_improvements)
    if (record.id == id) co_return record;
  co_return fail(ErrorCode::not_found, "NO_SUCH_IMPROVEMENT",
                 "there is no improvement " + std::to_string(id.value));
}

Awaitable<Result<std::vector<ImprovementRecord>>> FakeCell::improvements() {
  co_return std::vector<ImprovementRecord>(the_improvements.rbegin(), the_improvements.rend());
}

Awaitable<Result<ImprovementRecord>> FakeCell::cancel_improvement(app::Caller caller,
                                                                  ImprovementId id) {
  last_caller = caller;
  for (auto& record : the_improvements)
    if (record.id == id) {
      record.state = JobState::cancelled;
      publish_improvement({id, JobState::cancelled, 1, "cancelled"});
      co_return record;
    }
  co_return co_await improvement(id);
}

FakeCell::Watch FakeCell::watch_diagnoses(
    std::function<void(const app::DiagnosisProgress&)> on_change) {
  return counted(diagnosing_.add(std::move(on_change)));
}
FakeCell::Watch FakeCell::watch_improvements(
    std::function<void(const app::ImprovementProgress&)> on_change) {
  return counted(improving_.add(std::move(on_change)));
}

}  // namespace driftwise::tests
