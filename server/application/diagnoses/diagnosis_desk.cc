#include "server/application/diagnoses/diagnosis_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/post.hpp>
#include <chrono>

#include "server/application/plumbing/run_on.h"
#include "server/application/plumbing/task_group.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/diagnosis/diagnose.h"
#include "server/diagnosis/rows/catalogue_units.h"
#include "server/diagnosis/separating/separating.h"
#include "server/formats/diagnosis/separating_text.h"
#include "server/formats/diagnosis/stored_diagnosis.h"

namespace driftwise::application {
namespace {

using WallClock = std::chrono::steady_clock;
constexpr auto kTellEvery = std::chrono::milliseconds(50);
constexpr const char* kDaemonEnds = "the daemon was stopped while it ran";

std::string names_of(const diagnosis::Diagnosis& found) {
  std::string names;
  for (const auto& finding : found.findings)
    names += fmt::format("{}{}{}{}", names.empty() ? "" : ", ", finding.cause,
                         finding.subject.empty() ? "" : " ", finding.subject);
  return names;
}

// The search, and where it leaves a choice open the measurement that would make it: within what the
// data have seen, which the soft limits hold.
Result<diagnosis::Diagnosis> diagnose_and_design(const Dataset& dataset,
                                                 const diagnosis::DiagnoseOptions& options) {
  auto found = diagnosis::diagnose(dataset, options);
  const auto is_open = [](const diagnosis::Finding& finding) {
    return !finding.indistinguishable_from.empty();
  };
  if (!found || std::ranges::none_of(found->findings, is_open)) return found;
  if (!options.progress(0.99, "designing the measurement that would tell them apart"))
    return fail(ErrorCode::cancelled, reasons::kCancelled, "it was cancelled");
  const Dataset data = diagnosis::in_catalogue_units(dataset);
  const auto plan = diagnosis::separating_plan(
      data, diagnosis::in_catalogue_units(options.baseline), *found, diagnosis::limits_from(data));
  if (!plan)
    found->warnings.push_back("no separating measurement was designed: " + plan.error().message);
  else if (*plan)
    found->separating_experiment = formats::separating_text(**plan);
  return found;
}

// The search in one robot's part of the dataset; what is found has the names of the dataset.
Result<diagnosis::Diagnosis> found_in(const Dataset& dataset, const formats::RobotNames& names,
                                      const diagnosis::DiagnoseOptions& options,
                                      const Diagnose& diagnose) {
  if (names.robot().empty()) return diagnose(dataset, options);
  auto found = diagnose(names.bare(dataset), options);
  if (!found) return tl::unexpected(names.with_id(std::move(found.error())));
  return names.with_id(std::move(*found));
}

// What the worker's thread brings back: everything that costs time to make is made there.
struct Outcome {
  DiagnosisEnd end;
  std::string sentence;
};
Result<Outcome> outcome_of(DiagnosisId id, const Result<diagnosis::Diagnosis>& found,
                           const Dataset& dataset) {
  DRIFTWISE_RETURN_IF_ERROR(found);
  Outcome outcome;
  outcome.end.extended = found->extended_formula;
  outcome.end.result_json = formats::write_stored_diagnosis(*found);
  outcome.end.rows = formats::write_discrepancy_rows(formats::discrepancy_rows(dataset, *found));
  outcome.sentence = outcome_sentence(id, *found);
  return outcome;
}

}  // namespace

std::string outcome_sentence(DiagnosisId id, const diagnosis::Diagnosis& found) {
  const bool is_unexplained = found.verdict == diagnosis::Verdict::unexplained;
  const auto names = names_of(found);
  const auto robot = formats::robot_of_formula(found.baseline_formula);
  return fmt::format("diagnosis {}{}{} {}{}", id.value, robot.empty() ? "" : " of robot ", robot,
                     names.empty() ? "names no cause" : "found " + names,
                     is_unexplained ? "; structure remains that no cause explains" : "");
}

struct DiagnosisDesk::Job {
  Job(DiagnosisId number, const asio::any_io_executor& executor) : id(number), ended(executor) {
    progress.id = number;
    progress.step = "waiting for its turn";
  }
  const DiagnosisId id;
  std::atomic<bool> stop{false};  // shared with the worker; everything else is the executor's
  bool over = false;              // how it ends is decided, and
  bool stored = false;            // on disk, or the disk refuses it
  DiagnosisProgress progress;
  Signal ended;
};

DiagnosisDesk::DiagnosisDesk(asio::any_io_executor executor, asio::any_io_executor worker,
                             Clock& clock, StoreWriter& writer, EventLog& events, TaskGroup& tasks,
                             Diagnose diagnose)
    : executor_(executor),
      worker_(worker),
      clock_(clock),
      writer_(writer),
      events_(events),
      tasks_(tasks),
      diagnose_(diagnose ? std::move(diagnose) : Diagnose(&diagnose_and_design)) {}

DiagnosisDesk::~DiagnosisDesk() = default;

Awaitable<Result<DiagnosisRecord>> DiagnosisDesk::begin(const Caller& caller,
                                                        DiagnosisRecord wanted,
                                                        std::shared_ptr<const Dataset> dataset,
                                                        diagnosis::DiagnoseOptions options,
                                                        std::string robot) {
  if (ending_)
    co_return fail(ErrorCode::cancelled, reasons::kShuttingDown, "the daemon is shutting down");
  if (jobs_.size() >= kMostAtOnce)
    co_return fail(
        ErrorCode::resource_exhausted, reasons::kTooManyDiagnoses,
        fmt::format("{} diagnoses are under way or waiting: cancel one, or wait", jobs_.size()));
  const std::string who = caller.name, peer = caller.peer;
  wanted.created = clock_.now().utc;
  wanted.created_by = who;
  auto stored = co_await writer_.diagnoses().add_diagnosis(wanted);
  if (!stored) co_return stored;
  const Caller by{who, peer};
  events_.record(by, "diagnosis.started",
                 fmt::format("{} began diagnosis {}: {}", who, stored->id.value, stored->baseline));
  auto job = std::make_shared<Job>(stored->id, executor_);
  jobs_.emplace(stored->id, job);
  watchers_.publish(job->progress);
  formats::RobotNames names(*dataset, std::move(robot));
  tasks_.spawn(carry_out(std::move(job), std::move(dataset), std::move(options), std::move(names)));
  co_return stored;
}

Awaitable<void> DiagnosisDesk::carry_out(std::shared_ptr<Job> job,
                                         std::shared_ptr<const Dataset> dataset,
                                         diagnosis::DiagnoseOptions options,
                                         formats::RobotNames names) {
  options.progress = [this, job, names, last = WallClock::time_point{}](
                         double fraction, const std::string& step) mutable {
    const auto now = WallClock::now();
    if (now - last >= kTellEvery) {
      last = now;
      asio::post(executor_, [this, job, fraction, told = names.with_id(step)] {
        heard(*job, fraction, told);
      });
    }
    return !job->stop.load();
  };
  std::function<Result<Outcome>()> work = [this, job, dataset, options, names] {
    if (job->stop.load())
      return Result<Outcome>(fail(ErrorCode::cancelled, reasons::kCancelled, "it was cancelled"));
    return outcome_of(job->id, found_in(*dataset, names, options, diagnose_), *dataset);
  };
  auto found = co_await run_on(
      worker_, [](const std::function<Result<Outcome>()>& run) { return run(); }, std::move(work));
  if (!job->over) {
    DiagnosisEnd how;
    std::string told;
    if (found) {
      how = std::move(found->end);
      told = std::move(found->sentence);
    } else {
      how.state = JobState::failed;
      how.reason = found.error().message;
      told = fmt::format("diagnosis {} failed: {}", job->id.value, how.reason);
    }
    const char* what = found ? "diagnosis.done" : "diagnosis.failed";
    auto ending = end(job, std::move(how));
    if (co_await std::move(ending)) events_.record_own(what, std::move(told));
  }
  jobs_.erase(job->id);
}

// The first end stands: a cancelled one is over before its thread has noticed.
Awaitable<Result<void>> DiagnosisDesk::end(std::shared_ptr<Job> job, DiagnosisEnd how) {
  if (job->over)
    co_return fail(ErrorCode::failed_precondition, reasons::kAlreadyOver, "the diagnosis is over");
  job->over = true;
  how.at = clock_.now().utc;
  job->progress.state = how.state;
  job->progress.step = how.state == JobState::done ? "done" : how.reason;
  if (how.state == JobState::done) job->progress.fraction = 1;
  auto stored = co_await writer_.diagnoses().end_diagnosis(job->id, how);
  if (!stored)  // a full disk: the start after this one finds it unfinished
    events_.record_own("diagnosis.failed", fmt::format("diagnosis {} could not be stored: {}",
                                                       job->id.value, stored.error().message));
  job->stored = true;
  watchers_.publish(job->progress);
  job->ended.raise();
  co_return stored;
}

void DiagnosisDesk::heard(Job& job, double fraction, const std::string& step) {
  if (job.over) return;
  job.progress.fraction = std::max(job.progress.fraction, std::min(1.0, fraction));
  job.progress.step = step;
  watchers_.publish(job.progress);
}

Awaitable<Result<void>> DiagnosisDesk::cancel(const Caller& caller, DiagnosisId id) {
  const auto found = jobs_.find(id);
  if (found == jobs_.end() || found->second->over) co_return Result<void>{};
  const auto job = found->second;
  job->stop = true;
  DiagnosisEnd how;
  how.state = JobState::cancelled;
  how.reason = fmt::format("cancelled by {}", caller.name);
  events_.record(caller, "diagnosis.cancelled",
                 fmt::format("{} cancelled diagnosis {}", caller.name, id.value));
  auto ending = end(job, std::move(how));
  co_return co_await std::move(ending);
}

Awaitable<void> DiagnosisDesk::over(DiagnosisId id) {
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) co_return;
  const auto job = found->second;
  while (!job->stored) co_await job->ended.wait();
}

void DiagnosisDesk::tell_present(const std::function<void(const DiagnosisProgress&)>& to) const {
  for (const auto& [id, job] : jobs_) to(job->progress);
}

void DiagnosisDesk::shut_down() {
  ending_ = true;
  for (const auto& [id, job] : jobs_) {
    job->stop = true;
    if (job->over) continue;
    DiagnosisEnd how;
    how.state = JobState::failed;
    how.reason = kDaemonEnds;
    tasks_.spawn(
        [](DiagnosisDesk& desk, std::shared_ptr<Job> one, DiagnosisEnd last) -> Awaitable<void> {
          auto ending = desk.end(one, std::move(last));
          static_cast<void>(co_await std::move(ending));
        }(*this, job, std::move(how)));
  }
}

}  // namespace driftwise::application
