#pragma once
// Fakes of one small interface each, for what a real cell does not do on request: a fault, a run
// that changes when the test says so, figures that a page is to show. On the cell's thread.

#include <algorithm>
#include <atomic>
#include <boost/asio/steady_timer.hpp>
#include <exception>
#include <map>

#include "server/application/alarms/alarms.h"
#include "server/application/plumbing/watch_list.h"
#include "tests/support/live_cell.h"

namespace driftwise::tests {

// Watches that are counted.
template <class... Values>
class CountedWatch {
 public:
  std::shared_ptr<void> add(std::function<void(const Values&...)> callback) {
    ++now;
    ++begun;
    return std::shared_ptr<void>(this,
                                 [this, watch = list_.add(std::move(callback))](void*) mutable {
                                   watch.reset();
                                   --now;
                                 });
  }
  void publish(const Values&... values) { list_.publish(values...); }

  std::atomic<int> now = 0, begun = 0;

 private:
  app::WatchList<Values...> list_;
};

inline tl::unexpected<Error> not_faked() {
  return fail(ErrorCode::internal, "NOT_FAKED", "this fake does not do that");
}

// Throws what is there, once.
inline void throw_once(std::exception_ptr& error) {
  if (error) std::rethrow_exception(std::exchange(error, nullptr));
}

class FakeRuns final : public app::Runs {
 public:
  std::map<std::int64_t, RunRecord> runs;
  std::optional<Error> fail_next;
  std::exception_ptr throws_next;  // of get()
  app::CreateRun last_create;
  app::HoldAnswer last_answer;
  double last_force_n = 0;
  bool aborts_later = false;   // the answer to an abort shows the run as it was
  bool tells_at_once = false;  // a watcher hears of each unfinished run as soon as it watches
  CountedWatch<app::RunProgress> progress;

  RunRecord& add(std::int64_t id, RunState state = RunState::running) {
    auto& run = runs[id];
    run.id = {id};
    run.rows = 100;
    run.state = state;
    return run;
  }
  Awaitable<Result<RunRecord>> create(app::Caller caller, app::CreateRun request) override {
    last_create = request;
    if (request.validate_only) co_return RunRecord{};
    auto& run = add(std::ssize(runs) + 1);
    run.name = request.name;
    run.trajectory_name = request.trajectory_name;
    run.rows = 3;
    run.rules_json = "{}";
    run.operator_name = caller.name;
    run.created = run.started = kWorldBegin;
    co_return run;
  }
  Awaitable<Result<RunRecord>> pause(app::Caller caller, RunId id) override {
    auto changed = change(id, RunState::paused, "paused by " + caller.name);
    if (changed) {
      runs[id.value].hold = {RunHold::Kind::pause, caller.name, kWorldBegin, changed->reason};
      changed = runs[id.value];
    }
    co_return changed;
  }
  Awaitable<Result<RunRecord>> resume(app::Caller, RunId id, app::HoldAnswer answer) override {
    last_answer = std::move(answer);
    co_return change(id, RunState::running, "");
  }
  Awaitable<Result<RunRecord>> abort(app::Caller, RunId id, std::string why) override {
    auto before = find(id);
    auto changed = change(id, RunState::aborted, why);
    co_return aborts_later&& changed ? before : changed;
  }
  Awaitable<Result<RunRecord>> confirm_force(app::Caller, RunId id, double force_n) override {
    last_force_n = force_n;
    co_return change(id, RunState::running, "");
  }
  Awaitable<Result<RunRecord>> tag(app::Caller, RunId id, RunMetadata set,
                                   std::vector<std::string> removed) override {
    const auto found = runs.find(id.value);
    if (found == runs.end()) co_return fail(ErrorCode::not_found, "NO_SUCH_RUN", "no such run");
    found->second.metadata = changed_metadata(found->second.metadata, set, removed);
    co_return found->second;
  }
  Awaitable<Result<RunRecord>> get(RunId id) override {
    throw_once(throws_next);
    if (fail_next) co_return tl::unexpected(*std::exchange(fail_next, std::nullopt));
    co_return find(id);
  }
  std::shared_ptr<void> watch(std::function<void(const app::RunProgress&)> on_change) override {
    auto watch = progress.add(on_change);
    app::RunProgress told;
    for (const auto& [id, run] : runs) {
      if (!tells_at_once || is_over(run.state)) continue;
      told.run = run;
      on_change(told);
    }
    return watch;
  }

 private:
  Result<RunRecord> find(RunId id) const {
    const auto found = runs.find(id.value);
    if (found != runs.end()) return found->second;
    return fail(ErrorCode::not_found, "NO_SUCH_RUN", "there is no run " + std::to_string(id.value));
  }
  Result<RunRecord> change(RunId id, RunState state, std::string reason) {
    auto run = find(id);
    if (!run) return run;
    if (is_over(run->state)) return fail(ErrorCode::failed_precondition, "RUN_OVER", "it is over");
    run->state = state;
    run->reason = std::move(reason);
    run->hold = {};
    return runs[id.value] = *run;
  }
};

class FakeFeeds final : public app::Feeds {
 public:
  CountedWatch<EventRecord> events;
  CountedWatch<Reading> readings;
  CountedWatch<> records;
  std::exception_ptr throws_next;  // of watch_readings()

  std::shared_ptr<void> watch_events(std::function<void(const EventRecord&)> on_event) override {
    return events.add(std::move(on_event));
  }
  std::shared_ptr<void> watch_readings(std::function<void(const Reading&)> on_reading) override {
    throw_once(throws_next);
    return readings.add(std::move(on_reading));
  }
  std::shared_ptr<void> watch_records(std::function<void()> on_news) override {
    return records.add(std::move(on_news));
  }
};

// Alarms that the record does not have so, of which nothing is stored.
class FakeAlarms final : public app::Alarms {
 public:
  std::vector<AlarmRecord> missing;

  Awaitable<Result<std::vector<AlarmRecord>>> list(bool, int) override { co_return missing; }
  Awaitable<Result<AlarmRecord>> acknowledge(app::Caller, AlarmId) override {
    co_return not_faked();
  }
  Awaitable<Result<AlarmRecord>> shelve(app::Caller, AlarmId, double, std::string) override {
    co_return not_faked();
  }
  Awaitable<Result<AlarmRecord>> unshelve(app::Caller, AlarmId) override { co_return not_faked(); }
  std::vector<AlarmRecord> unwritten(std::size_t) const override { return missing; }
};

class FakeDatasets final : public app::Datasets {
 public:
  std::exception_ptr throws_next;  // of export_csv()

  Awaitable<Result<Dataset>> load(std::vector<RunId>, std::string) override {
    co_return not_faked();
  }
  Awaitable<Result<std::vector<std::string>>> set_names(std::vector<RunId>, std::string) override {
    co_return not_faked();
  }
  Awaitable<Result<std::string>> export_csv(std::vector<RunId>, bool) override {
    throw_once(throws_next);
    co_return "x_mm\n1\n";
  }
  Awaitable<Result<RunRecord>> import_csv(app::Caller, std::string, std::string,
                                          std::string) override {
    co_return not_faked();
  }
  Awaitable<Result<app::JoinAnswer>> join(app::Caller, app::JoinRequest) override {
    co_return not_faked();
  }
};

class FakeTargets final : public app::Targets {
 public:
  compensation::SnapshotBoard board;
  CountedWatch<> rebuilt;
  app::PastTargetsQuery last_past;
  app::PastTargets the_past;

  void publish(compensation::Snapshot snapshot) {
    static_cast<void>(board.publish(std::move(snapshot)));
    rebuilt.publish();
  }
  const compensation::SnapshotBoard& snapshots() const override { return board; }
  std::shared_ptr<void> watch_snapshots(std::function<void()> on_rebuilt) override {
    return rebuilt.add(std::move(on_rebuilt));
  }
  Awaitable<Result<app::PastTargets>> past(app::PastTargetsQuery query) const override {
    const_cast<FakeTargets*>(this)->last_past = query;
    co_return the_past;
  }
};

// Tells one step, and answers what the test set or waits to be stopped.
class FakeStudies final : public app::Studies {
 public:
  std::vector<identification::Judgement> judgements;
  app::SensorChoice choice;
  std::optional<Error> fail_next;
  bool waits = false;
  app::MethodsRequest last_methods;
  app::SensorsRequest last_sensors;
  std::shared_ptr<app::Study> last;  // the asker's

  Awaitable<Result<std::vector<identification::Judgement>>> compare_methods(
      app::MethodsRequest request, std::shared_ptr<app::Study> study) override {
    last_methods = std::move(request);
    if (fail_next) co_return tl::unexpected(*fail_next);
    auto looking = studied(std::move(study));
    if (!co_await std::move(looking)) co_return fail(ErrorCode::cancelled, "CANCELLED", "stopped");
    co_return judgements;
  }
  Awaitable<Result<app::SensorChoice>> study_sensors(app::SensorsRequest request,
                                                     std::shared_ptr<app::Study> study) override {
    last_sensors = std::move(request);
    auto looking = studied(std::move(study));
    if (!co_await std::move(looking)) co_return fail(ErrorCode::cancelled, "CANCELLED", "stopped");
    co_return choice;
  }

 private:
  Awaitable<bool> studied(std::shared_ptr<app::Study> study) {  // false: it was stopped
    last = study;
    study->tell({"looking", 0.5});
    asio::steady_timer timer(co_await asio::this_coro::executor);
    while (waits && !study->stopped()) {
      timer.expires_after(std::chrono::milliseconds(2));
      co_await timer.async_wait(asio::use_awaitable);
    }
    co_return !study->stopped();
  }
};

class FakeModelChecks final : public app::ModelChecks {
 public:
  diagnosis::CheckReport report;
  diagnosis::Verification verification;
  std::vector<RunRecord> runs;

  Awaitable<Result<app::ModelCheck>> check_model(std::optional<ModelId> id, std::vector<RunId>,
                                                 std::optional<CorrectionId>) override {
    if (!id) co_return fail(ErrorCode::failed_precondition, "NO_MODEL", "no model serves");
    co_return app::ModelCheck{*id, runs, report};
  }
  Awaitable<Result<diagnosis::Verification>> verify_runs(std::vector<RunId>,
                                                         std::optional<ModelId>) override {
    co_return verification;
  }
};

// A fit is any model of that formula; the rest is asked of the cell.
class FakeModels final : public app::Models {
 public:
  explicit FakeModels(LiveCell& cell) : cell_(cell) {}
  app::FitRequest last_fit;
  std::vector<calibration::OfferResult> offers;
  app::FormulaCheck formula_check;
  app::ModelResiduals the_residuals;

  Awaitable<Result<ModelRecord>> fit(app::Caller, app::FitRequest request) override {
    last_fit = request;
    return get(cell_.put_model(request.formula));
  }
  Awaitable<Result<app::KinematicFit>> create_kinematic(app::Caller caller,
                                                        app::KinematicRequest request) override {
    return cell_.services().models.create_kinematic(std::move(caller), std::move(request));
  }
  Awaitable<Result<std::vector<calibration::OfferResult>>> weigh_offers(app::FitRequest) override {
    co_return offers;
  }
  Awaitable<Result<app::FormulaCheck>> check_formula(app::FitRequest request) override {
    last_fit = request;
    co_return formula_check;
  }
  Awaitable<Result<app::ModelResiduals>> residuals(ModelId, std::vector<RunId>,
                                                   std::string) override {
    co_return the_residuals;
  }
  Awaitable<Result<std::vector<app::ListedModel>>> list() override {
    return cell_.services().models.list();
  }
  Awaitable<Result<ModelRecord>> get(ModelId id) override {
    return cell_.services().models.get(id);
  }

 private:
  LiveCell& cell_;
};

class FakeDiagnoses final : public app::Diagnoses {
 public:
  CountedWatch<app::DiagnosisProgress> progress;

  Awaitable<Result<app::DiagnosisView>> create(app::Caller, app::DiagnosisRequest) override {
    co_return not_faked();
  }
  Awaitable<Result<app::DiagnosisView>> get(DiagnosisId) override { co_return not_faked(); }
  Awaitable<Result<std::vector<app::DiagnosisView>>> list() override { co_return not_faked(); }
  Awaitable<Result<app::DiagnosisView>> cancel(app::Caller, DiagnosisId) override {
    co_return not_faked();
  }
  std::shared_ptr<void> watch(
      std::function<void(const app::DiagnosisProgress&)> on_change) override {
    return progress.add(std::move(on_change));
  }
};

class FakeImprovements final : public app::Improvements {
 public:
  CountedWatch<app::ImprovementProgress> progress;
  std::optional<ImprovementRecord> begins;  // what create() answers with

  Awaitable<Result<ImprovementRecord>> create(app::Caller, app::ImproveRequest) override {
    if (!begins) co_return not_faked();
    co_return *begins;
  }
  Awaitable<Result<ImprovementRecord>> cancel(app::Caller, ImprovementId) override {
    co_return not_faked();
  }
  std::shared_ptr<void> watch(
      std::function<void(const app::ImprovementProgress&)> on_change) override {
    return progress.add(std::move(on_change));
  }
};

// Keeps on record that findings were accepted and undone; makes nothing of them.
class FakeExtensions final : public app::Extensions {
 public:
  explicit FakeExtensions(LiveCell& cell) : cell_(cell) {}
  app::ExtensionPreview the_preview;
  std::optional<ModelId> makes;
  app::Caller last_caller;

  Awaitable<Result<app::ExtensionPreview>> preview(app::AcceptRequest) override {
    co_return the_preview;
  }
  Awaitable<Result<ExtensionRecord>> accept(app::Caller caller,
                                            app::AcceptRequest request) override {
    last_caller = caller;
    NewExtension fresh;
    fresh.diagnosis = request.diagnosis;
    fresh.findings = request.findings.empty() ? std::vector<int>{1} : request.findings;
    fresh.model = makes;
    fresh.promoted = request.promote;
    fresh.at = {kWorldBegin, 0};
    fresh.who = caller.name;
    co_return cell_.store().extensions().accept(fresh);
  }
  Awaitable<Result<ExtensionRecord>> undo(app::Caller caller, DiagnosisId id) override {
    co_return cell_.store().extensions().undo_extension(id, {kWorldBegin, 1}, caller.name, "", {});
  }

 private:
  LiveCell& cell_;
};

// Puts the question of a start that is on record.
class FakeConfigurations final : public app::Configurations {
 public:
  explicit FakeConfigurations(LiveCell& cell) : cell_(cell) {}
  app::ConfigurationView view;
  std::int64_t start = 0;
  std::string last_note;

  Awaitable<Result<app::ConfigurationView>> get(std::string hash, std::string) override {
    auto shown = view;
    if (!hash.empty()) shown.hash = hash;
    co_return shown;
  }
  Awaitable<Result<ConfigurationStart>> accept(app::Caller caller, std::string,
                                               std::string note) override {
    last_note = note;
    co_return cell_.store().configurations().accept(start, kWorldBegin, caller.name, note, {});
  }

 private:
  LiveCell& cell_;
};

}  // namespace driftwise::tests
