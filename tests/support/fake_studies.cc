// FakeCell's studies: they tell one step, and answer what the test set or wait to be stopped.

#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>

#include "tests/support/fake_cell.h"

namespace driftwise::tests {

Awaitable<bool> FakeCell::studied(std::shared_ptr<app::Study> study) {
  last_study = study;
  study->tell({"looking", 0.5});
  asio::steady_timer timer(executor());
  while (studies_wait && !study->stopped()) {
    timer.expires_after(std::chrono::milliseconds(2));
    co_await timer.async_wait(asio::use_awaitable);
  }
  co_return !study->stopped();
}

Awaitable<Result<std::vector<identification::Judgement>>> FakeCell::compare_methods(
    app::MethodsRequest request, std::shared_ptr<app::Study> study) {
  last_methods = std::move(request);
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  auto looking = studied(std::move(study));
  if (!co_await std::move(looking)) co_return fail(ErrorCode::cancelled, "CANCELLED", "stopped");
  co_return the_judgements;
}

Awaitable<Result<app::SensorChoice>> FakeCell::study_sensors(app::SensorsRequest request,
                                                             std::shared_ptr<app::Study> study) {
  last_sensors = std::move(request);
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  auto looking = studied(std::move(study));
  if (!co_await std::move(looking)) co_return fail(ErrorCode::cancelled, "CANCELLED", "stopped");
  co_return the_choice;
}

}  // namespace driftwise::tests
