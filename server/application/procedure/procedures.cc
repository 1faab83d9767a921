#include "server/application/procedure/procedures.h"

#include "server/application/checks/model_checks.h"
#include "server/application/models/models.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/ports/run_plan.h"
#include "server/application/provenance/provenance.h"
#include "server/application/status/overview.h"
#include "server/calibration/report/accuracy.h"
#include "server/compensation/model_budget.h"
#include "server/core/try.h"
#include "server/formats/model/model_json.h"

namespace driftwise::application {
namespace {

constexpr int kMostRuns = 1000;

bool is_temperature(const Channel& channel) {
  return channel.unit == "degC" || channel.unit == "K";
}

}  // namespace

std::vector<ProcedureSource> sources_of(const CellDescription& cell,
                                        const std::vector<LatestValue>& values) {
  ProcedureSource lengths{"geometry (lengths)", ""}, angles{"parasitic rotations", ""},
      robot{"temperatures of the robot", ""}, bench{"temperatures of the instruments", ""},
      air{"temperature of the air", ""}, weather{"pressure and humidity of the air", ""},
      force{"process force", ""};
  const auto add = [](ProcedureSource& to, const Channel& channel) {
    to.measured_by += (to.measured_by.empty() ? "" : ", ") + channel.name();
  };
  for (const auto& device : cell.devices) {
    if (device.length()) {
      add(lengths, device.length()->channel);
      // An interferometer's thermometer is that of the air along its beam.
      for (const auto& value : values)
        if (value.device == device.id && is_temperature(value.channel)) add(air, value.channel);
    }
    for (const auto& angle : device.angles()) add(angles, angle.channel);
    for (const auto& probe : device.probes())
      add(probe.part == "air" ? air : probe.part == "instrument" ? bench : robot, probe.channel);
    if (device.force()) add(force, *device.force());
    if (std::holds_alternative<ForceSettings>(device.settings))
      for (const auto& quantity : device.quantities()) add(force, quantity.channel);
    if (std::holds_alternative<EnvironmentSettings>(device.settings))
      for (const auto& quantity : device.quantities())
        add(is_temperature(quantity.channel) ? air : weather, quantity.channel);
  }
  // Weights that a person hangs: nothing measures them, and the record knows them.
  if (force.measured_by.empty())
    if (const auto channel = cell.force_channel()) add(force, *channel);
  return {lengths, angles, robot, bench, air, weather, force};
}

void take_runs(const std::vector<RunRecord>& newest_first, ProcedureFacts& facts) {
  for (const auto& run : newest_first) {
    if (is_of_file(run)) continue;
    const bool done = run.state == RunState::done, compensated = compensation_of(run).compensated;
    facts.runs.push_back({.id = run.id.value,
                          .setup = setup_of(run),
                          .done = done,
                          .compensated = compensated,
                          .points = run.reason == "imported" ? 0 : run.accepted,
                          .joined = run.reason == "imported"});
    if (compensated && done && !facts.verified_run) facts.verified_run = run.id.value;
    if (facts.campaign) continue;
    for (const auto& item : run.metadata) {
      if (!states_wanted_accuracy(item.key)) continue;
      auto wanted = wanted_accuracy_from(item);
      if (wanted)
        add_wanted(facts.wanted, std::move(*wanted));
      else
        facts.unreadable.push_back("run " + std::to_string(run.id.value) + ": " +
                                   wanted.error().message);
    }
    if (!facts.wanted.empty()) facts.campaign = run.id.value;
  }
}

Awaitable<Result<std::vector<ProcedureStep>>> Procedures::steps() {
  ProcedureFacts facts;
  facts.sources = sources_of(cell_.overview.description(), cell_.overview.status().values);
  DRIFTWISE_CO_TRY(const auto runs, co_await cell_.records.runs().runs(kMostRuns, 0));
  take_runs(runs, facts);
  DRIFTWISE_CO_RETURN_IF_ERROR(co_await look_at_model(facts));
  co_await look_at_verification(facts);
  co_return procedure_steps(facts);
}

// The one that serves, else the newest that can be read.
Awaitable<Result<void>> Procedures::look_at_model(ProcedureFacts& facts) {
  DRIFTWISE_CO_TRY(const auto listed, co_await cell_.models.list());
  const auto serving = cell_.overview.status().serving;
  std::optional<ModelId> best;
  for (const auto& [record, summary] : listed) {
    if (!record.damage.empty()) continue;
    if (!best || serving == record.id || serving != *best) best = record.id;
  }
  if (!best) co_return Result<void>{};
  auto getting = cell_.models.get(*best);
  const auto chosen = co_await std::move(getting);
  if (!chosen) co_return Result<void>{};
  const auto model = formats::read_model_json(chosen->json);
  if (!model) co_return Result<void>{};
  ProcedureFacts::Model found{.id = chosen->id.value,
                              .serving = serving == chosen->id,
                              .validation_rows = model->lineage.rows_validation};
  for (const auto& output : model->outputs) {
    const auto judged =
        driftwise::heading_of(calibration::judged_accuracies(output, model->lineage)).front();
    found.accuracy.push_back({judged.output, judged.unit, judged.figures.a90});
  }
  auto looking = cell_.provenance.ground_of_model(chosen->id);
  DRIFTWISE_CO_TRY(const auto ground, co_await std::move(looking));
  const auto& measured_under =
      ground.measured_under ? *ground.measured_under : cell_.overview.description();
  if (const auto snapshot = compensation::model_snapshot(*model, measured_under)) {
    if (const auto line = compensation::largest_line(*snapshot)) {
      found.largest_line = compensation::shown_name(line->source);
      found.largest_u_nm = line->u_nm;
      found.combined_u_nm = line->combined_u_nm;
      found.largest_is_measured = !compensation::is_declared(line->source);
    }
  }
  if (found.serving) {
    auto checking = cell_.checks.check_model(chosen->id, {});
    if (const auto check = co_await std::move(checking);
        check && check->report.verdict == diagnosis::CheckVerdict::recalibrate)
      for (const auto& reason : check->report.reasons)
        found.doubt += (found.doubt.empty() ? "" : "; ") + reason;
  }
  facts.model = std::move(found);
  co_return Result<void>{};
}

Awaitable<void> Procedures::look_at_verification(ProcedureFacts& facts) {
  if (!facts.verified_run) co_return;
  std::vector<RunId> runs{RunId{*facts.verified_run}};
  auto verifying = cell_.checks.verify_runs(std::move(runs), std::nullopt);
  const auto verified = co_await std::move(verifying);
  if (!verified) {
    facts.not_verified = verified.error().message;
    co_return;
  }
  for (const auto& run : verified->runs)
    for (const auto& one : run.coordinates)
      facts.verified.push_back({one.channel.symbol, one.unit, one.all.a90});
}

}  // namespace driftwise::application
