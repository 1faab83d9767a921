#include "server/application/diagnoses/diagnosis_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/post.hpp>
#include <chrono>
#include <optional>

#include "server/application/plumbing/run_on.h"
#include "server/application/plumbing/store_refusal.h"
#include "server/application/plumbing/task_group.h"
#include "server/core/reasons.h"
#include "server/core/records/state_text.h"
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
constexpr double kStoreAgain_s = 5;  // of cell time
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
  Job(DiagnosisId number, const asio::any_io_executor& executor) : id(number), changed(executor) {
    progress.id = number;
    progress.step = "waiting for its turn";
  }
  const DiagnosisId id;
  std::atomic<bool> stop{false};  // shared with the worker; everything else is the executor's
  bool over = false;              // how it ends is decided, and
  bool closed = false;            // on disk, or the daemon ends before the disk takes it
  std::optional<Error> refused;   // why the end is not on disk yet
  DiagnosisProgress progress;
  Signal changed;
};

// How one ends, and the event that says so once it is on disk. No event: it is recorded already.
struct DiagnosisDesk::Ending {
  DiagnosisEnd how;
  std::string event = {}, sentence = {};
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
  const Caller by = caller;
  wanted.created = clock_.now().utc;
  wanted.created_by = by.name;
  auto stored = co_await writer_.diagnoses().add_diagnosis(wanted);
  if (!stored) co_return stored;
  events_.record(
      by, "diagnosis.started",
      fmt::format("{} began diagnosis {}: {}", by.name, stored->id.value, stored->baseline));
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
    Ending last;
    last.event = found ? "diagnosis.done" : "diagnosis.failed";
    if (found) {
      last.how = std::move(found->end);
      last.sentence = std::move(found->sentence);
    } else {
      last.how.state = JobState::failed;
      last.how.reason = found.error().message;
      last.sentence = fmt::format("diagnosis {} failed: {}", job->id.value, last.how.reason);
    }
    auto ending = end(job, std::move(last));
    static_cast<void>(co_await std::move(ending));
  }
  while (!job->closed) co_await job->changed.wait();
  jobs_.erase(job->id);
}

// The first end stands: a cancelled one is over before its thread has noticed. One try to store it,
// for whoever waits for the answer; what the disk refuses is tried again on the side.
Awaitable<Result<void>> DiagnosisDesk::end(std::shared_ptr<Job> job, Ending last) {
  if (job->over)
    co_return fail(ErrorCode::failed_precondition, reasons::kAlreadyOver, "the diagnosis is over");
  job->over = true;
  last.how.at = clock_.now().utc;
  auto stored = co_await writer_.diagnoses().end_diagnosis(job->id, last.how);
  if (stored || ending_) {
    close(*job, last, stored.has_value());
    co_return stored;
  }
  job->refused = stored.error();
  events_.record_own("diagnosis.trouble", waits_to_be_stored(*job, last));
  job->progress.step =
      fmt::format("{}: waiting until the database takes it", is_text(last.how.state));
  watchers_.publish(job->progress);
  tasks_.spawn(store_later(std::move(job), std::move(last)));
  co_return stored;
}

// The record is not over before its end is on it: who waits for a diagnosis reads the record.
Awaitable<void> DiagnosisDesk::store_later(std::shared_ptr<Job> job, Ending last) {
  for (bool is_stored = false; !is_stored && !ending_;) {
    if (!may_be_stored_later(*job->refused) && last.how.state == JobState::done)
      last = not_storable(*job);  // waiting changes nothing: the record says that at least
    else
      co_await sleep_until_due(*job);
    const auto stored = co_await writer_.diagnoses().end_diagnosis(job->id, last.how);
    is_stored = stored || stored.error().reason == reasons::kAlreadyOver;
    if (is_stored)
      job->refused.reset();
    else
      job->refused = stored.error();
  }
  close(*job, last, !job->refused);
}

Awaitable<void> DiagnosisDesk::sleep_until_due(Job& job) {
  const auto due = clock_.now().utc + nanoseconds_from_s(kStoreAgain_s);
  while (clock_.now().utc < due && !ending_) co_await sleep_unless(clock_, due, job.changed);
}

DiagnosisDesk::Ending DiagnosisDesk::not_storable(const Job& job) const {
  Ending last;
  last.how.at = clock_.now().utc;
  last.how.state = JobState::failed;
  last.how.reason = "what it found could not be stored: " + job.refused->message;
  last.event = "diagnosis.failed";
  last.sentence = fmt::format("diagnosis {} failed: {}", job.id.value, last.how.reason);
  return last;
}

std::string DiagnosisDesk::waits_to_be_stored(const Job& job, const Ending& last) {
  return fmt::format(
      "diagnosis {} {}, but the database does not take it: {}. It is tried again every {:g} s "
      "until the database does, or the daemon ends",
      job.id.value, is_text(last.how.state), job.refused->message, kStoreAgain_s);
}

// stored: false where the daemon ends before; the start after this one finds it unfinished.
void DiagnosisDesk::close(Job& job, const Ending& last, bool stored) {
  job.closed = true;
  job.progress.state = stored ? last.how.state : JobState::failed;
  job.progress.step = !stored                            ? kDaemonEnds
                      : last.how.state == JobState::done ? "done"
                                                         : last.how.reason;
  if (job.progress.state == JobState::done) job.progress.fraction = 1;
  if (stored && !last.event.empty()) events_.record_own(last.event, last.sentence);
  watchers_.publish(job.progress);
  job.changed.raise();
}

void DiagnosisDesk::heard(Job& job, double fraction, const std::string& step) {
  if (job.over) return;
  job.progress.fraction = std::max(job.progress.fraction, std::min(1.0, fraction));
  job.progress.step = step;
  watchers_.publish(job.progress);
}

Awaitable<Result<void>> DiagnosisDesk::cancel(const Caller& caller, DiagnosisId id) {
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) co_return Result<void>{};
  const auto job = found->second;
  if (job->over && job->refused)
    co_return fail(job->refused->code, job->refused->reason,
                   fmt::format("diagnosis {} is over and nothing is left to cancel, but the "
                               "database does not take its end: {}. It is tried again by itself",
                               id.value, job->refused->message));
  if (job->over) co_return Result<void>{};
  job->stop = true;
  Ending last;
  last.how.state = JobState::cancelled;
  last.how.reason = fmt::format("cancelled by {}", caller.name);
  events_.record(caller, "diagnosis.cancelled",
                 fmt::format("{} cancelled diagnosis {}", caller.name, id.value));
  auto ending = end(job, std::move(last));
  co_return co_await std::move(ending);
}

void DiagnosisDesk::tell_present(const std::function<void(const DiagnosisProgress&)>& to) const {
  for (const auto& [id, job] : jobs_) to(job->progress);
}

void DiagnosisDesk::shut_down() {
  ending_ = true;
  for (const auto& [id, job] : jobs_) {
    job->stop = true;
    job->changed.raise();  // an end that waits for the disk is tried once more
    if (job->over) continue;
    Ending last;
    last.how.state = JobState::failed;
    last.how.reason = kDaemonEnds;
    tasks_.spawn([](DiagnosisDesk& desk, std::shared_ptr<Job> one, Ending how) -> Awaitable<void> {
      auto ending = desk.end(one, std::move(how));
      static_cast<void>(co_await std::move(ending));
    }(*this, job, std::move(last)));
  }
}

}  // namespace driftwise::application
