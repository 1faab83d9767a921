#include "server/application/runs/runs_service.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/application/motion/loading.h"
#include "server/application/plans/joint_rows.h"
#include "server/application/plumbing/run_on.h"
#include "server/application/ports/run_hold.h"
#include "server/application/recording/doubts.h"
#include "server/application/runs/run_state_store.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::application {

RunsService::RunsService(Workbench& bench, StoreReader& reader, RunEngine& engine,
                         RightToMove& right, StopEvents& stop_events, Trajectories& trajectories,
                         Models& models, Serving& serving, const JointServing& joint_serving,
                         const ConfigurationBook& configuration, asio::any_io_executor background)
    : description_(bench.description),
      clock_(bench.clock),
      recorder_(bench.recorder),
      writer_(bench.writer),
      events_(bench.events),
      stops_(bench.stops),
      doubts_(bench.doubts),
      boot_id_(bench.boot_id),
      reader_(reader),
      engine_(engine),
      right_(right),
      stop_events_(stop_events),
      trajectories_(trajectories),
      models_(models),
      serving_(serving),
      joint_serving_(joint_serving),
      configuration_(configuration),
      background_(std::move(background)) {}

Result<void> check_coordinates(const std::string& name, const Trajectory& trajectory,
                               bool compensate) {
  const auto& first = trajectory.coordinates.front();
  const bool is_pose = is_pose_symbol(without_robot(first.symbol));
  if (compensate && !is_pose)
    return fail(ErrorCode::invalid_argument, reasons::kNothingToCompensate,
                fmt::format("{}: column {}: compensation needs wanted poses (x_mm ...), these are "
                            "motor coordinates",
                            name, first.name()));
  const bool of_several_robots = !robot_of(first.symbol).empty();
  if (is_pose && !compensate && of_several_robots)
    return fail(
        ErrorCode::invalid_argument, reasons::kNeedsCompensation,
        fmt::format("{}: column {}: with several robots a pose becomes motor coordinates by "
                    "the serving plan: compensate, or hand in motor coordinates",
                    name, first.name()));
  if (is_pose && !compensate && (trajectory.coordinates.size() > 1 || is_angle(first.unit)))
    return fail(ErrorCode::invalid_argument, reasons::kNeedsCompensation,
                fmt::format("{}: column {}: with several axes, or of a rotation, a pose is no "
                            "motor coordinate: "
                            "compensate with a model",
                            name, first.name()));
  return {};
}

namespace {

const SetupDescription* chosen_setup(const CellDescription& cell, const std::string& name) {
  const auto found = std::ranges::find(cell.setups, name, &SetupDescription::name);
  return found == cell.setups.end() ? nullptr : &*found;
}

bool is_measured_in(const SetupDescription& setup, const Channel& coordinate) {
  return std::ranges::any_of(setup.coordinates, [&](const SetupCoordinate& one) {
    return one.channel.name() == coordinate.name();
  });
}

std::string coordinates_of_setup(const SetupDescription& setup) {
  std::string names;
  for (const auto& one : setup.coordinates)
    names += (names.empty() ? "" : ", ") + one.channel.name();
  return names;
}

// A set-up of another robot than those that the trajectory moves measures nothing of it.
Result<void> check_setup_measures(const CellDescription& cell, const std::string& setup_name,
                                  const Trajectory& trajectory, const std::string& name) {
  const auto* setup = chosen_setup(cell, setup_name);
  if (setup == nullptr || !cell.has_several_robots()) return {};
  std::string robots;
  for (const auto& moved : trajectory.coordinates) {
    const std::string robot(robot_of(moved.symbol));
    if (std::ranges::any_of(setup->coordinates, [&](const SetupCoordinate& one) {
          return robot_of(one.channel.symbol) == robot;
        }))
      return {};
    if (robots.find(robot) == std::string::npos) robots += (robots.empty() ? "" : ", ") + robot;
  }
  return fail(ErrorCode::invalid_argument, reasons::kNotMeasured,
              fmt::format("{}: moves {}, and set-up '{}' measures {} alone: no point of this run "
                          "would have a measured coordinate of what moves. Start it in a set-up "
                          "that measures one of {}'s",
                          name, robots, setup_name, coordinates_of_setup(*setup), robots));
}

// Wanted coordinates that this set-up leaves to another run of the same trajectory; empty: none.
std::string wanted_but_unmeasured(const CellDescription& cell, const std::string& setup_name,
                                  const Trajectory& trajectory) {
  const auto* setup = chosen_setup(cell, setup_name);
  std::string names;
  if (setup == nullptr) return names;
  for (const auto& wanted : trajectory.coordinates)
    if (is_pose_symbol(without_robot(wanted.symbol)) && !is_measured_in(*setup, wanted))
      names += (names.empty() ? "" : ", ") + wanted.name();
  return names;
}

}  // namespace

Awaitable<Result<RunRecord>> RunsService::create(Caller caller, CreateRun request) {
  const auto lock = co_await right_.turn();
  // A repeated request gets the first one's answer, whatever has become of the lease since.
  if (const auto* run = engine_.record();
      run && !request.request_id.empty() && run->request_id == request.request_id)
    co_return *run;
  if (!request.validate_only) DRIFTWISE_CO_RETURN_IF_ERROR(right_.check(request.lease_token));
  DRIFTWISE_CO_TRY(request.metadata, checked_metadata(std::move(request.metadata)));
  const auto stops = stop_events_.presses();
  DRIFTWISE_CO_TRY(auto prepared, co_await prepare(request));
  if (request.validate_only) co_return co_await would_be(request, prepared);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await follow_for(prepared.plan));
  if (stop_events_.presses() != stops)
    co_return fail(ErrorCode::aborted, reasons::kStoppedMeanwhile,
                   "a stop was asked for while the trajectory was read: start the run again");
  co_return co_await start_run(std::move(caller), std::move(request), std::move(prepared.plan),
                               std::move(prepared.trajectory));
}

Awaitable<Result<RunRecord>> RunsService::would_be(const CreateRun& request,
                                                   const Prepared& prepared) {
  if (prepared.plan.compensate_with) {
    auto looking = models_.get(*prepared.plan.compensate_with);
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(looking));
  }
  RunRecord record;
  record.name = request.name.empty() ? request.trajectory_name : request.name;
  record.trajectory_name = request.trajectory_name;
  record.rows = static_cast<std::int64_t>(prepared.trajectory.points.size());
  co_return record;
}

Awaitable<Result<RunsService::Prepared>> RunsService::prepare(const CreateRun& request) {
  RunPlan plan{request.rules.value_or(description_.run),
               request.compensate || request.compensate_with, request.compensate_with, std::nullopt,
               request.setup};
  DRIFTWISE_CO_RETURN_IF_ERROR(check_setup(description_, plan.setup));
  DRIFTWISE_CO_RETURN_IF_ERROR(check_rules(plan.rules));
  const auto name =
      request.trajectory_name.empty() ? std::string("trajectory") : request.trajectory_name;
  auto checking = trajectories_.check(name, request.trajectory_text);
  DRIFTWISE_CO_TRY(auto check, co_await std::move(checking));
  DRIFTWISE_CO_RETURN_IF_ERROR(check_coordinates(name, check.trajectory, plan.compensate));
  DRIFTWISE_CO_RETURN_IF_ERROR(
      check_setup_measures(description_, plan.setup, check.trajectory, name));
  if (plan.compensate)
    DRIFTWISE_CO_RETURN_IF_ERROR(co_await settle_compensation(plan, check.trajectory, name));
  co_return Prepared{std::move(plan), std::move(check.trajectory)};
}

Awaitable<Result<void>> RunsService::settle_compensation(RunPlan& plan,
                                                         const Trajectory& trajectory,
                                                         const std::string& name) {
  if (!description_.has_several_robots()) {
    if (plan.compensate_with) co_return Result<void>{};  // follow_for
    plan.served_at_start = serving_.model();
    if (serving_.refused()) co_return tl::unexpected(*serving_.refused());
    if (!serving_.model())
      co_return fail(ErrorCode::failed_precondition, reasons::kNoModel,
                     "no model serves: promote one, or run without compensation");
    co_return Result<void>{};
  }
  if (plan.compensate_with)
    co_return fail(ErrorCode::invalid_argument, reasons::kWrongCoordinates,
                   fmt::format("found model {} to compensate with, expected none: with several "
                               "robots the serving plan says what each moves by",
                               plan.compensate_with->value));
  plan.plan_at_start = joint_serving_.plan();
  if (joint_serving_.refused()) co_return tl::unexpected(*joint_serving_.refused());
  if (!plan.plan_at_start)
    co_return fail(ErrorCode::failed_precondition, reasons::kNoPlan,
                   "no serving plan serves: 'driftwise plan promote N', or hand in motor "
                   "coordinates and run without compensation");
  co_return co_await run_on(background_, check_joint_rows, std::cref(description_),
                            joint_serving_.snapshot_now(), trajectory, name, clock_.now().utc);
}

Awaitable<Result<void>> RunsService::follow_for(const RunPlan& plan) {
  if (!plan.compensate_with) co_return Result<void>{};
  DRIFTWISE_CO_TRY(auto record, co_await models_.get(*plan.compensate_with));
  co_return co_await serving_.follow(std::move(record));
}

Awaitable<Result<RunRecord>> RunsService::start_run(Caller caller, CreateRun request, RunPlan plan,
                                                    Trajectory trajectory) {
  NewRun fresh;
  fresh.name = request.name.empty() ? request.trajectory_name : request.name;
  fresh.trajectory_name = request.trajectory_name;
  fresh.trajectory_text = request.trajectory_text;
  fresh.rows = static_cast<std::int64_t>(trajectory.points.size());
  fresh.rules_json = write_run_plan(plan);
  fresh.config_hash = description_.hash;
  fresh.config_text = description_.text;
  fresh.operator_name = caller.name;
  fresh.request_id = request.request_id;
  fresh.created = clock_.now();
  fresh.boot_id = boot_id_;
  fresh.metadata = request.metadata;
  fresh.queue_entry = request.queue_entry;
  const auto stops = stop_events_.presses();
  auto stored = co_await writer_.runs().create_run(fresh);
  if (!stored) co_return stored;
  const bool is_new = stored->state == RunState::queued || stored->state == RunState::paused;
  if (stored->created != fresh.created.utc || !is_new) co_return stored;
  // A stop pressed meanwhile found no run under way to halt.
  if (stop_events_.presses() != stops) pause_by_stop(*stored, stop_events_.hold());
  events_.record(caller, "run.created",
                 fmt::format("{} created run {} '{}': {} rows", caller.name, stored->id.value,
                             stored->name, stored->rows),
                 stored->id);
  if (const auto left = wanted_but_unmeasured(description_, plan.setup, trajectory); !left.empty())
    events_.record_own("run.unmeasured",
                       fmt::format("run {}: set-up '{}' does not measure {}, which its trajectory "
                                   "wants: join it with a run of the same trajectory that does",
                                   stored->id.value, plan.setup, left),
                       stored->id);
  engine_.begin(*stored, std::move(plan), std::move(trajectory), std::nullopt, true,
                std::move(request.announce));
  co_return present();
}

Result<RunControl*> RunsService::control_of(RunId run, const char* verb) {
  const auto* record = engine_.record();
  if (record && record->id == run) return engine_.control();
  return fail(ErrorCode::failed_precondition, reasons::kRunNotUnderWay,
              fmt::format("run {} cannot {}: {}", run.value, verb,
                          record ? fmt::format("run {} is the one under way", record->id.value)
                                 : "no run is under way"));
}

Awaitable<Result<RunRecord>> RunsService::steer(Caller caller, RunId id, const char* verb,
                                                std::string detail,
                                                std::function<void(RunControl&)> act) {
  if (auto known = co_await get(id); !known) co_return known;
  DRIFTWISE_CO_TRY(auto control, control_of(id, verb));
  events_.record(caller, fmt::format("run.{}", verb), std::move(detail), id);
  act(*control);
  co_return present();
}

Awaitable<Result<RunRecord>> RunsService::pause(Caller caller, RunId run) {
  auto why = fmt::format("paused by {}", caller.name);
  const RunHold hold{RunHold::Kind::pause, caller.name, clock_.now().utc, why};
  std::function<void(RunControl&)> act = [hold](RunControl& control) { control.hold(hold); };
  co_return co_await steer(caller, run, "pause", why, std::move(act));
}

Result<RunControl*> RunsService::check_resume(const Caller& caller, RunId id,
                                              const HoldAnswer& answer) {
  DRIFTWISE_RETURN_IF_ERROR(stops_.check());
  if (const auto* record = engine_.record(); record && record->id == id)
    if (auto question = configuration_.question_for(*record); !question.empty())
      return fail(ErrorCode::failed_precondition, reasons::kConfigurationChanged,
                  fmt::format("run {} cannot resume: {}", id.value, question));
  DRIFTWISE_TRY(auto* control, control_of(id, "resume"));
  if (right_.by_hand())
    return fail(ErrorCode::failed_precondition, reasons::kMoving,
                "a movement by hand is under way: wait for its end, or stop it");
  DRIFTWISE_RETURN_IF_ERROR(
      check_answer(*engine_.record(), control->hold(), caller.name, answer, clock_.now().utc));
  return control;
}

// On record before the robot moves. Meanwhile nobody else begins a motion, and a stop, or another
// pause, makes the answer one to a question of before.
Awaitable<Result<RunRecord>> RunsService::resume(Caller caller, RunId id, HoldAnswer answer) {
  if (auto known = co_await get(id); !known) co_return known;
  const auto lock = co_await right_.turn();
  DRIFTWISE_CO_TRY(auto* control, check_resume(caller, id, answer));
  const auto now = clock_.now().utc;
  const RunHold hold = control->hold();
  auto detail =
      fmt::format("resumed by {}: {}", caller.name, hold_sentence(*engine_.record(), hold, now));
  if (hold.kind == RunHold::Kind::stop && hold.who != caller.name)
    detail += fmt::format("; the stop was overridden: {}", answer.override_reason);
  auto recording = events_.record_first(caller, "run.resume", std::move(detail), id);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(recording));
  if (auto still = check_resume(caller, id, answer); !still) {
    events_.record_own("run.resume_refused", still.error().message, id);
    co_return tl::unexpected(still.error());
  } else {
    control = *still;
  }
  doubts_.begin_anew();  // a person looked: what the devices say now is taken as right
  control->resume();
  co_return *engine_.record();
}

Awaitable<Result<RunRecord>> RunsService::abort(Caller caller, RunId run, std::string why) {
  auto reason = fmt::format("aborted by {}{}{}", caller.name, why.empty() ? "" : ": ", why);
  std::function<void(RunControl&)> act = [reason](RunControl& control) { control.abort(reason); };
  auto record = co_await steer(caller, run, "abort", reason, std::move(act));
  auto pressing = stops_.press(caller, fmt::format("run {} {}", run.value, reason));
  if (record) co_await std::move(pressing);
  co_return record;
}

Result<void> RunsService::check_confirmation(RunId id, double force_n) {
  DRIFTWISE_TRY(const auto* control, control_of(id, "confirm a force"));
  DRIFTWISE_RETURN_IF_ERROR(control->check());
  const auto& wanted_n = control->wanted_force();
  if (!wanted_n)
    return fail(ErrorCode::failed_precondition, reasons::kNoForceWanted,
                fmt::format("run {} does not wait for a force, it is {}", id.value,
                            to_string(engine_.record()->state)));
  if (same_force(*wanted_n, force_n)) return {};
  return fail(ErrorCode::invalid_argument, reasons::kWrongForce,
              fmt::format("{:g} N was confirmed, run {} waits for {:g} N: {}", force_n, id.value,
                          *wanted_n, hang_sentence(*wanted_n, *description_.load)));
}

Awaitable<Result<RunRecord>> RunsService::confirm_force(Caller caller, RunId id, double force_n) {
  if (auto known = co_await get(id); !known) co_return known;
  DRIFTWISE_CO_RETURN_IF_ERROR(check_confirmation(id, force_n));
  auto recording = events_.record_first(
      caller, "load.confirmed", fmt::format("{} confirmed {:.6g} N", caller.name, force_n), id);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await std::move(recording));
  DRIFTWISE_CO_RETURN_IF_ERROR(check_confirmation(id, force_n));
  // On disk before the run goes on: a restart must know what hangs there.
  const auto now = clock_.now().utc;
  Reading said{kOperatorDevice, now, now, 0, {{description_.force_channel()->name(), force_n}}};
  recorder_.observe(JudgedReading{said, {}});
  writer_.add(std::move(said));
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await writer_.flush());
  // An abort may have ended the run, and its control with it, while this was stored.
  DRIFTWISE_CO_RETURN_IF_ERROR(check_confirmation(id, force_n));
  engine_.control()->confirm_force();
  co_return *engine_.record();
}

Awaitable<Result<RunRecord>> RunsService::tag(Caller caller, RunId id, RunMetadata set,
                                              std::vector<std::string> removed) {
  DRIFTWISE_CO_TRY(set, checked_metadata(std::move(set)));
  DRIFTWISE_CO_TRY(const auto before, co_await get(id));
  DRIFTWISE_CO_RETURN_IF_ERROR(checked_metadata(changed_metadata(before.metadata, set, removed)));
  auto tagging = writer_.metadata().tag(id, std::move(set), std::move(removed));
  DRIFTWISE_CO_TRY(const auto stored, co_await std::move(tagging));
  engine_.take_metadata(id, stored.metadata);
  auto after = metadata_text(stored.metadata);
  auto detail =
      fmt::format("{} tagged run {}: {}", caller.name, id.value, after.empty() ? "nothing" : after);
  events_.record(caller, "run.tagged", std::move(detail), id,
                 {{}, metadata_text(before.metadata), std::move(after)});
  co_return co_await get(id);
}

// The run under way. A pause or stop that is asked for is in force, and can be ended, before the
// point under way is through.
RunRecord RunsService::present() const {
  RunRecord record = *engine_.record();
  if (record.hold.kind == RunHold::Kind::none) record.hold = engine_.control()->hold();
  return record;
}

Awaitable<Result<RunRecord>> RunsService::get(RunId run) {
  if (const auto* record = engine_.record(); record && record->id == run) co_return present();
  co_return co_await reader_.call([=](Store& store) { return store.runs().run(run); });
}

std::shared_ptr<void> RunsService::watch(std::function<void(const RunProgress&)> on_change) {
  if (engine_.progress()) on_change(*engine_.progress());
  return engine_.watchers().add(std::move(on_change));
}

}  // namespace driftwise::application
