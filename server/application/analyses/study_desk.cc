#include "server/application/analyses/study_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <chrono>
#include <mutex>

#include "server/application/plumbing/fit_threads.h"
#include "server/application/plumbing/task_group.h"
#include "server/core/reasons.h"

namespace driftwise::application {
namespace {

using StudyClock = std::chrono::steady_clock;
constexpr auto kSayEvery = std::chrono::milliseconds(50);

}  // namespace

// Jobs on several threads may speak at once.
struct StudyBench::Voice {
  Voice(asio::any_io_executor where, std::shared_ptr<Study> of)
      : executor(std::move(where)), study(std::move(of)) {}

  void say(double fraction, const std::string& step) {
    const std::lock_guard lock(mutex);
    const auto now = StudyClock::now();
    highest = std::max(highest, std::min(1.0, fraction));
    if (step == last_step && now - last < kSayEvery) return;
    last = now;
    last_step = step;
    asio::post(executor, [one = study, progress = StudyProgress{step, highest}] {
      if (!one->stopped()) one->tell(progress);
    });
  }

  const asio::any_io_executor executor;
  const std::shared_ptr<Study> study;
  std::mutex mutex;
  StudyClock::time_point last{};
  std::string last_step;
  double highest = 0;
};

StudyBench::StudyBench(asio::any_io_executor executor, std::shared_ptr<Study> study)
    : study_(study), voice_(std::make_shared<Voice>(std::move(executor), std::move(study))) {}

StudyBench::~StudyBench() = default;

void StudyBench::say(double fraction, const std::string& step) { voice_->say(fraction, step); }

calibration::Executor StudyBench::sharing(int threads) const {
  return [study = study_, on_threads = fit_threads(threads)](
             std::size_t count, const std::function<void(std::size_t)>& job) {
    calibration::run_on(on_threads, count, [&](std::size_t i) {
      if (study->stopped()) throw StudyStopped{};
      job(i);
    });
  };
}

calibration::Executor StudyBench::counting(int threads, const std::string& step) {
  return [voice = voice_, share = sharing(threads), step](
             std::size_t count, const std::function<void(std::size_t)>& job) {
    std::atomic<std::size_t> done = 0;
    share(count, [&](std::size_t i) {
      job(i);
      voice->say(static_cast<double>(++done) / static_cast<double>(count), step);
    });
  };
}

StudyDesk::StudyDesk(asio::any_io_executor executor, asio::any_io_executor worker, TaskGroup& tasks)
    : executor_(std::move(executor)), worker_(std::move(worker)), tasks_(tasks) {}

Result<void> StudyDesk::may_begin(const std::shared_ptr<Study>& study) {
  if (ending_ || study->stopped()) return study_was_stopped();
  if (studies_.size() >= kMostAtOnce)
    return fail(
        ErrorCode::resource_exhausted, reasons::kTooManyStudies,
        fmt::format("{} studies are under way or waiting: leave one, or wait", studies_.size()));
  studies_.push_back(study);
  return {};
}

void StudyDesk::leave(const std::shared_ptr<Study>& study) { std::erase(studies_, study); }

void StudyDesk::shut_down() {
  ending_ = true;
  for (const auto& study : studies_) study->stop();
}

}  // namespace driftwise::application
