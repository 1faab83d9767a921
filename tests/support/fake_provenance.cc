#include "server/core/try.h"
#include "tests/support/fake_cell.h"

namespace driftwise::tests {

Awaitable<Result<std::vector<ConfigurationStart>>> FakeCell::configurations(int) {
  co_return the_starts;
}

Awaitable<Result<app::ConfigurationView>> FakeCell::configuration(std::string hash,
                                                                  std::string compare_hash) {
  auto view = the_configuration;
  if (!hash.empty()) view.hash = hash;
  if (!compare_hash.empty()) view.compared_hash = compare_hash;
  co_return view;
}

Awaitable<Result<ConfigurationStart>> FakeCell::accept_configuration(app::Caller caller,
                                                                     std::string hash,
                                                                     std::string note) {
  last_caller = caller;
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  if (the_starts.empty() || !the_starts.front().is_open())
    co_return fail(ErrorCode::failed_precondition, "NO_QUESTION", "there is nothing to accept");
  calls.push_back("accept_configuration " + hash + " " + note);
  auto& start = the_starts.front();
  start.accepted = the_time;
  start.accepted_by = caller.name;
  start.note = note;
  co_return start;
}

Awaitable<Result<std::vector<app::RunGround>>> FakeCell::grounds_of_runs(std::vector<RunId> runs) {
  co_return std::vector<app::RunGround>(runs.size(), the_run_ground);
}

Awaitable<Result<app::ModelGround>> FakeCell::ground_of_model(ModelId) {
  co_return the_model_ground;
}

Awaitable<Result<std::vector<CorrectionRecord>>> FakeCell::corrections() {
  co_return the_corrections;
}

Awaitable<Result<app::ExtensionPreview>> FakeCell::preview_extension(app::AcceptRequest request) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  DRIFTWISE_CO_RETURN_IF_ERROR(find_diagnosis(request.diagnosis));
  co_return the_preview;
}

}  // namespace driftwise::tests
