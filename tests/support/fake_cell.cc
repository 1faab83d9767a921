#include "tests/support/fake_cell.h"

#include <algorithm>
#include <boost/asio/executor_work_guard.hpp>

#include "server/core/try.h"
#include "server/formats/model/model_json.h"

namespace driftwise::tests {

namespace {

calibration::TermReport report(const effects::Term& term, bool in, double coefficient,
                               double contribution_rms) {
  calibration::TermReport out;
  out.term = term;
  out.in = in;
  out.coefficient = coefficient;
  out.standard_error = 1e-7;
  out.t = coefficient / out.standard_error;
  out.p = in ? 1e-20 : 0.62;
  out.vif = in ? 1.2 : 0;
  out.contribution_rms = contribution_rms;
  out.contribution_max = 2 * contribution_rms;
  return out;
}

calibration::Model small_model(const std::string& formula) {
  using namespace calibration;
  Model model;
  model.formula = formula;
  OutputModel output;
  output.channel = {"q1", "mm"};
  const effects::Term constant, x{{effects::Power{"x", 1}}}, t07{{effects::Power{"t07", 1}}};
  output.terms = {constant, x};
  output.coefficients = Eigen::Vector2d(1e-6, 1.0);
  output.covariance = Eigen::Matrix2d::Identity() * 1e-14;
  output.dof = 558;
  output.accuracy.rmse = 5e-6;
  output.accuracy.u90_calibration = 8.2e-6;
  output.accuracy.a90_calibration = 8.2e-6;
  output.accuracy.u90_validation = 9.1e-6;
  output.accuracy.mean_validation = 2e-6;
  output.accuracy.a90_validation = 9.7e-6;
  output.report = {report(constant, true, 1e-6, 0), report(x, true, 1.0, 2.3),
                   report(t07, false, 1e-7, 1.1e-8)};
  output.history = {{1, "enter", x, 0.0, 5e-6, 558}};
  model.outputs = {output};
  model.domain = {{{"x", "mm"}, -4, 4}};
  model.lineage.runs = {{1}};
  model.lineage.source = "runs 1";
  model.lineage.dataset_hash = "abc";
  model.lineage.rows_calibration = 560;
  model.lineage.rows_validation = 448;
  model.fit_us = 48.1;
  return model;
}

}  // namespace

FakeCell::FakeCell() {
  description_.name = "linear-axis";
  description_.hash = "0123456789abcdef";
  DeviceDescription axis;
  axis.id = "axis";
  axis.kind = "pi-gcs";
  axis.address = "127.0.0.1:50000";
  axis.become<MotionSettings>().axes = {{{"q1", "mm"}, "X", -4.5, 4.5, 5}};
  description_.devices = {axis};
  the_model_ground.configurations = {{description_.hash, the_time}};
  the_model_ground.measured_under = description_;
  the_model_ground.present_hash = description_.hash;
  the_status.name = "linear-axis";
  the_status.version = "0.1.0";
  the_status.now = {the_time, 0};
  the_status.devices = {
      {axis, DeviceHealth{LinkState::connected, "PI C-863", 10, 0, 0, 0.002, "", the_time}}};
  the_status.values = {{{"t07", "degC"}, 20.5123, the_time, 1.5, false, "scanner"},
                       {{"t08", "degC"}, kMissing, {}, 0, true, "scanner"}};
  thread_ = std::thread([this] {
    const auto work = asio::make_work_guard(context_);
    context_.run();
  });
}

FakeCell::~FakeCell() {
  asio::post(context_, [this] { context_.stop(); });
  thread_.join();
}

asio::any_io_executor FakeCell::executor() const {
  return const_cast<asio::io_context&>(context_).get_executor();
}

void FakeCell::publish_snapshot(compensation::Snapshot snapshot) {
  static_cast<void>(board.publish(std::move(snapshot)));
  snapshots_.publish();
}

EventId FakeCell::add_event(const std::string& what) {
  EventRecord event;
  event.id = {static_cast<std::int64_t>(the_events.size()) + 1};
  event.at = {the_time, 0};
  event.who = "daemon";
  event.what = what;
  the_events.push_back(event);
  event_watch_.publish(event);
  return event.id;
}

ModelId FakeCell::add_model(const std::string& formula) {
  ModelRecord record;
  record.id = {static_cast<std::int64_t>(the_models.size()) + 1};
  record.name = "first";
  record.json = formats::write_model_json(small_model(formula));
  record.hash = "hash" + std::to_string(record.id.value);
  record.created = the_time;
  record.created_by = "ada";
  the_models.push_back(record);
  return record.id;
}

std::optional<Error> FakeCell::take_failure() { return std::exchange(fail_next, std::nullopt); }

Result<RunRecord> FakeCell::find_run(RunId run) const {
  const auto found = the_runs.find(run.value);
  if (found == the_runs.end())
    return fail(ErrorCode::not_found, "NO_RUN", "there is no run " + std::to_string(run.value));
  return found->second;
}

Result<void> FakeCell::check_lease(const std::string& token) const {
  if (lease_ && lease_->token == token) return {};
  return fail(ErrorCode::permission_denied, "LEASE_REQUIRED", "take the lease first");
}

Result<app::Lease> FakeCell::take_lease(const app::Caller& caller, Nanoseconds duration,
                                        const std::string& token) {
  if (auto error = take_failure()) return tl::unexpected(*error);
  if (lease_ && lease_->token != token)
    return fail(ErrorCode::permission_denied, "LEASE_HELD", lease_->holder + " holds the lease");
  last_caller = caller;
  lease_ = app::Lease{"token-" + caller.name, caller.name, caller.peer, the_time + duration};
  the_status.lease = lease_;
  return *lease_;
}

Result<void> FakeCell::give_up_lease(const app::Caller&, const std::string& token) {
  if (auto good = check_lease(token); !good) return good;
  calls.push_back("give_up_lease");
  lease_.reset();
  the_status.lease.reset();
  return {};
}

Awaitable<Result<app::TrajectoryCheck>> FakeCell::check_trajectory(std::string text) {
  if (text.find("bad") != std::string::npos)
    co_return fail(ErrorCode::invalid_argument, "BAD_NUMBER",
                   "line 3, column x_mm: found 'bad', expected a number");
  app::TrajectoryCheck check;
  check.trajectory.coordinates = {{"x", "mm"}};
  check.trajectory.points.resize(3);
  check.calibration = 2;
  check.validation = 1;
  check.lines = 1;
  check.zeros = 1;
  check.estimated_s = 42.5;
  check.warnings = {"only one line"};
  co_return check;
}

Awaitable<Result<RunRecord>> FakeCell::create_run(app::Caller caller, app::CreateRun request) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  DRIFTWISE_CO_RETURN_IF_ERROR(check_lease(request.lease_token));
  for (const auto& [id, run] : the_runs)
    if (!request.request_id.empty() && run.request_id == request.request_id) co_return run;
  last_caller = caller;
  last_create = request;
  RunRecord run;
  run.id = {static_cast<std::int64_t>(the_runs.size()) + 1};
  run.name = request.name;
  run.trajectory_name = request.trajectory_name;
  run.trajectory_text = request.trajectory_text;
  run.rows = 3;
  run.rules_json = "{}";
  run.operator_name = caller.name;
  run.request_id = request.request_id;
  run.state = RunState::running;
  run.created = run.started = the_time;
  the_runs[run.id.value] = run;
  co_return run;
}

Result<RunRecord> FakeCell::change_state(const app::Caller& caller, RunId id, RunState state,
                                         std::string reason) {
  if (auto error = take_failure()) return tl::unexpected(*error);
  auto run = find_run(id);
  if (!run) return run;
  if (is_over(run->state))
    return fail(ErrorCode::failed_precondition, "RUN_OVER",
                "run " + std::to_string(id.value) + " is over");
  last_caller = caller;
  run->state = state;
  run->reason = std::move(reason);
  run->hold = {};
  if (state == RunState::paused)
    run->hold = {RunHold::Kind::pause, caller.name, the_time, run->reason};
  the_runs[id.value] = *run;
  return run;
}

Awaitable<Result<RunRecord>> FakeCell::pause_run(app::Caller caller, RunId run) {
  co_return change_state(caller, run, RunState::paused, "paused by " + caller.name);
}
Awaitable<Result<RunRecord>> FakeCell::resume_run(app::Caller caller, RunId run,
                                                  app::HoldAnswer answer) {
  last_answer = std::move(answer);
  co_return change_state(caller, run, RunState::running, "");
}
Awaitable<Result<RunRecord>> FakeCell::abort_run(app::Caller caller, RunId run, std::string why) {
  auto before = find_run(run);
  auto changed = change_state(caller, run, RunState::aborted, why);
  co_return aborts_later&& changed ? before : changed;
}

Awaitable<Result<RunRecord>> FakeCell::confirm_force(app::Caller caller, RunId run,
                                                     double force_n) {
  calls.push_back("confirm_force " + caller.name + " " + std::to_string(force_n));
  co_return change_state(caller, run, RunState::running, "");
}

Awaitable<Result<app::StopAnswer>> FakeCell::stop_all(app::Caller caller) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  last_caller = caller;
  calls.push_back("stop_all " + caller.name);
  co_return stop_answer;
}
Awaitable<Result<void>> FakeCell::home(app::Caller caller, std::string lease_token,
                                       app::HoldAnswer answer) {
  last_answer = std::move(answer);
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  if (auto good = check_lease(lease_token); !good) co_return good;
  calls.push_back("home " + caller.name);
  co_return Result<void>{};
}
Awaitable<Result<void>> FakeCell::move_to(app::Caller caller, std::string lease_token,
                                          std::vector<double> q_mm, app::HoldAnswer answer) {
  last_answer = std::move(answer);
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  if (auto good = check_lease(lease_token); !good) co_return good;
  if (q_mm.at(0) < -4.5 || q_mm.at(0) > 4.5)
    co_return fail(ErrorCode::out_of_range, "OUTSIDE_LIMITS",
                   "q1_mm: the soft limits are -4.5 to 4.5 mm");
  calls.push_back("move_to " + caller.name + " q=" + std::to_string(q_mm.at(0)));
  co_return Result<void>{};
}
Awaitable<Result<void>> FakeCell::set_stabiliser(app::Caller, std::string lease_token,
                                                 std::string device, double degc) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  if (auto good = check_lease(lease_token); !good) co_return good;
  calls.push_back("set_stabiliser " + device + " " + std::to_string(degc));
  co_return Result<void>{};
}

app::Cell::Watch FakeCell::counted(std::shared_ptr<void> watch) {
  ++watchers;
  ++watchers_begun;
  return std::shared_ptr<void>(watch.get(), [this, watch](void*) mutable {
    watch.reset();
    --watchers;
  });
}
app::Cell::Watch FakeCell::watch_progress(std::function<void(const app::RunProgress&)> on_change) {
  return counted(progress_.add(std::move(on_change)));
}
app::Cell::Watch FakeCell::watch_events(std::function<void(const EventRecord&)> on_event) {
  return counted(event_watch_.add(std::move(on_event)));
}
app::Cell::Watch FakeCell::watch_readings(std::function<void(const Reading&)> on_reading) {
  return counted(readings_.add(std::move(on_reading)));
}
app::Cell::Watch FakeCell::watch_snapshots(std::function<void()> on_rebuilt) {
  return counted(snapshots_.add(std::move(on_rebuilt)));
}

Awaitable<Result<std::vector<RunRecord>>> FakeCell::runs(int limit, std::int64_t before_id) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  std::vector<RunRecord> out;
  for (auto next = the_runs.rbegin();
       next != the_runs.rend() && static_cast<int>(out.size()) < limit; ++next)
    if (before_id == 0 || next->first < before_id) out.push_back(next->second);
  co_return out;
}
Awaitable<Result<RunRecord>> FakeCell::run(RunId run) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  co_return find_run(run);
}
Awaitable<Result<std::vector<PointRecord>>> FakeCell::points(RunId run, std::int64_t after_id,
                                                             int limit) {
  DRIFTWISE_CO_RETURN_IF_ERROR(find_run(run));
  std::vector<PointRecord> out;
  for (const auto& point : the_points)
    if (point.id.value > after_id && static_cast<int>(out.size()) < limit) out.push_back(point);
  co_return out;
}
Awaitable<Result<std::vector<AttemptRecord>>> FakeCell::attempts(RunId run) {
  DRIFTWISE_CO_RETURN_IF_ERROR(find_run(run));
  co_return the_attempts;
}
Awaitable<Result<std::vector<DatumRecord>>> FakeCell::data(RunId run) {
  DRIFTWISE_CO_RETURN_IF_ERROR(find_run(run));
  co_return the_datums;
}
Awaitable<Result<std::vector<EventRecord>>> FakeCell::events(EventId after, int limit) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  std::vector<EventRecord> out;
  for (const auto& event : the_events)
    if (event.id > after && static_cast<int>(out.size()) < limit) out.push_back(event);
  co_return out;
}

Awaitable<Result<std::string>> FakeCell::export_dataset(std::vector<RunId> runs,
                                                        bool without_excluded) {
  last_without_excluded = without_excluded;
  for (const RunId run : runs) DRIFTWISE_CO_RETURN_IF_ERROR(find_run(run));
  co_return the_csv;
}
Awaitable<Result<RunRecord>> FakeCell::import_dataset(app::Caller caller, std::string name,
                                                      std::string csv, std::string request_id) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  last_request_id = std::move(request_id);
  the_csv = std::move(csv);
  RunRecord run;
  run.id = {static_cast<std::int64_t>(the_runs.size()) + 1};
  run.name = std::move(name);
  run.operator_name = caller.name;
  run.state = RunState::done;
  the_runs[run.id.value] = run;
  co_return run;
}

Awaitable<Result<app::ExclusionState>> FakeCell::exclude_rows(app::Caller caller,
                                                              ExclusionRecord wanted) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  DRIFTWISE_CO_RETURN_IF_ERROR(find_run(wanted.run));
  wanted.id = static_cast<std::int64_t>(the_exclusions.size()) + 1;
  wanted.who = caller.name;
  wanted.at.utc = the_time;
  the_exclusions.push_back(wanted);
  co_return co_await exclusions(wanted.run);
}
Awaitable<Result<app::ExclusionState>> FakeCell::exclusions(RunId run) {
  DRIFTWISE_CO_RETURN_IF_ERROR(find_run(run));
  app::ExclusionState state{run, {}, {}, "state", the_exclusions};
  if (!the_exclusions.empty() && the_exclusions.back().excluded)
    state.rows = the_exclusions.back().rows;
  co_return state;
}
Awaitable<Result<NoteRecord>> FakeCell::add_note(app::Caller caller, NoteSubject on,
                                                 std::string text) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  NoteRecord note{static_cast<std::int64_t>(the_notes.size()) + 1,
                  on,
                  std::move(text),
                  {the_time, 0},
                  caller.name,
                  caller.peer};
  the_notes.push_back(note);
  co_return note;
}
Awaitable<Result<std::vector<NoteRecord>>> FakeCell::notes(NoteSubject on) {
  std::vector<NoteRecord> found;
  for (const auto& note : the_notes)
    if (note.on.run == on.run && note.on.model == on.model) found.push_back(note);
  co_return found;
}

Awaitable<Result<ModelRecord>> FakeCell::fit(app::Caller caller, app::FitRequest request) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  last_caller = caller;
  last_fit = request;
  co_return co_await model(add_model(request.formula));
}
Awaitable<Result<std::vector<calibration::OfferResult>>> FakeCell::weigh_offers(app::FitRequest) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  co_return the_offers;
}
Awaitable<Result<app::FormulaCheck>> FakeCell::check_formula(app::FitRequest request) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  last_fit = request;
  co_return the_formula_check;
}
Awaitable<Result<diagnosis::Verification>> FakeCell::verify_runs(std::vector<RunId>,
                                                                 std::optional<ModelId>) {
  co_return the_verification;
}
Awaitable<Result<app::ModelResiduals>> FakeCell::residuals(ModelId id, std::vector<RunId>,
                                                           std::string) {
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await model(id));
  co_return the_residuals;
}
Awaitable<Result<app::ModelCheck>> FakeCell::check_model(std::optional<ModelId> id,
                                                         std::vector<RunId> runs) {
  if (!id && !the_status.serving)
    co_return fail(ErrorCode::failed_precondition, "NO_MODEL", "no model serves");
  DRIFTWISE_CO_TRY(auto record, co_await model(id ? *id : *the_status.serving));
  app::ModelCheck check{record.id, {}, the_check};
  for (const auto& [number, run] : the_runs)
    if (runs.empty() || std::ranges::find(runs, RunId{number}) != runs.end())
      check.runs.push_back(run);
  co_return check;
}
Awaitable<Result<std::vector<ModelRecord>>> FakeCell::models() {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  co_return the_models;
}
Awaitable<Result<ModelRecord>> FakeCell::model(ModelId id) {
  for (const auto& model : the_models)
    if (model.id == id) co_return model;
  co_return fail(ErrorCode::not_found, "NO_MODEL", "there is no model " + std::to_string(id.value));
}
Awaitable<Result<ModelRecord>> FakeCell::promote(app::Caller caller, ModelId id, bool confirmed) {
  auto record = co_await model(id);
  if (!record) co_return record;
  if (!confirmed && !the_model_ground.promotion_questions.empty())
    co_return fail(ErrorCode::failed_precondition, "NEEDS_CONFIRMATION",
                   the_model_ground.promotion_questions.front());
  the_status.serving = id;
  the_promotions.push_back({id, the_time, caller.name, "promote"});
  co_return record;
}
Awaitable<Result<std::optional<ModelRecord>>> FakeCell::roll_back(app::Caller caller) {
  if (auto error = take_failure()) co_return tl::unexpected(*error);
  the_status.serving.reset();
  the_promotions.push_back({std::nullopt, the_time, caller.name, "rollback"});
  co_return std::optional<ModelRecord>{};
}
Awaitable<Result<std::vector<PromotionRecord>>> FakeCell::promotions() { co_return the_promotions; }

}  // namespace driftwise::tests
