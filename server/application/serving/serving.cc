#include "server/application/serving/serving.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/application/plumbing/task_group.h"
#include "server/application/serving/memory.h"
#include "server/application/serving/past_targets.h"
#include "server/compensation/target.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/model/model_json.h"

namespace driftwise::application {
namespace {

constexpr auto kShortestRebuild = std::chrono::milliseconds(500);

}  // namespace

Serving::Serving(asio::any_io_executor executor, const CellDescription& description,
                 const ConfigurationBook& configuration, Clock& clock, Recorder& recorder,
                 StoreReader& reader, EventLog& events, TaskGroup& tasks)
    : executor_(executor),
      description_(description),
      configuration_(configuration),
      clock_(clock),
      recorder_(recorder),
      reader_(reader),
      events_(events),
      tasks_(tasks),
      ended_(executor) {}

void Serving::start() {
  watch_ = recorder_.watchers().add([this](const Reading& reading) { observe(reading); });
  tasks_.spawn(rebuild_for_ever());
}

void Serving::shut_down() {
  ending_ = true;
  ended_.raise();
}

Awaitable<Result<Serving::Followed>> Serving::load(ModelRecord record) {
  DRIFTWISE_CO_TRY(auto model, formats::read_model_json(record.json));
  auto origin = co_await origin_of(model, reader_, description_.hash);
  DRIFTWISE_CO_TRY(auto builder, compensation::SnapshotBuilder::create(std::move(model), record.id,
                                                                       description_));
  Followed followed{std::move(builder), std::move(origin)};
  // Effects with memory count in the datum as they stood at its zero.
  std::vector<Reading> readings;
  std::optional<DatumId> datum;
  do {
    datum = datum_ ? std::optional(datum_->id) : std::nullopt;
    MemoryQuery wanted{followed.builder.observed_channels(), followed.builder.memory(),
                       zero_of(datum_)};
    auto stored = co_await reader_.call(
        [cell = &description_, now = clock_.now().utc](Store& store, const MemoryQuery& query) {
          return readings_for_memory(store, *cell, query, now);
        },
        std::move(wanted));
    readings = stored ? std::move(*stored) : std::vector<Reading>();
  } while (datum_ && datum_->id != datum);  // zeroed meanwhile
  append_latest(recorder_, readings);
  replay(readings, zero_of(datum_), followed.builder, [&] { set_anchor(record.id, followed); });
  co_return followed;
}

Awaitable<Result<void>> Serving::serve(std::optional<ModelRecord> model) {
  if (model) {
    DRIFTWISE_CO_TRY(auto loaded, co_await load(*model));
    followed_.insert_or_assign(model->id, std::move(loaded));
    serving_ = model->id;
  } else {
    serving_.reset();
  }
  refused_.reset();
  rebuild();
  forget_others();
  co_return Result<void>{};
}

void Serving::refuse(ModelId model, Error why) {
  events_.record_own("serving.refused",
                     fmt::format("model {} does not serve: {}", model.value, why.message));
  serving_.reset();
  refused_ = std::move(why);
  rebuild();
}

Awaitable<Result<void>> Serving::follow(ModelRecord model) {
  compensating_ = model.id;
  if (followed_.contains(model.id)) co_return Result<void>{};
  DRIFTWISE_CO_TRY(auto loaded, co_await load(model));
  followed_.insert_or_assign(model.id, std::move(loaded));
  forget_others();
  co_return Result<void>{};
}

void Serving::forget_others() {
  std::erase_if(followed_, [this](const auto& one) {
    return one.first != serving_ && one.first != compensating_;
  });
}

void Serving::doubt(std::optional<ModelId> model) {
  if (doubtful_ == model) return;
  doubtful_ = model;
  rebuild();
}

void Serving::anchor(const DatumRecord& datum) {
  datum_ = datum;
  for (auto& [id, followed] : followed_) set_anchor(id, followed);
  rebuild();
}

std::string Serving::trouble() const {
  const auto served = serving_ ? followed_.find(*serving_) : followed_.end();
  return served == followed_.end() ? std::string() : served->second.trouble;
}

void Serving::set_anchor(ModelId id, Followed& followed) {
  followed.trouble.clear();
  if (!datum_) return;
  if (followed.origin.own_datum == datum_->id) {
    followed.builder.keep_model_datum();
    return;
  }
  if (const auto ok = followed.builder.anchor(datum_->values); !ok) {
    followed.trouble = fmt::format("datum {} does not anchor model {}: {}", datum_->id.value,
                                   id.value, ok.error().message);
    events_.record_own("serving.unanchored", followed.trouble);
  }
}

void Serving::observe(const Reading& reading) {
  for (auto& [id, followed] : followed_) followed.builder.observe(reading);
  if (!serving_ || clock_.now().utc - built_at_ < kShortestRebuild) return;
  for (const auto& channel : followed_.at(*serving_).builder.observed_channels())
    if (reading.find(channel)) return rebuild();
}

compensation::Snapshot Serving::snapshot_of(const Followed& followed, CellTime now) const {
  auto snapshot = followed.builder.build(now);
  snapshot.doubtful = is_doubtful(snapshot.model);
  if (!configuration_.asks()) return snapshot;
  snapshot.configuration_changed = true;
  if (!followed.origin.under_present)
    snapshot.changed_parts = configuration_.changes_of(followed.origin.symbols);
  return snapshot;
}

void Serving::rebuild() {
  built_at_ = clock_.now().utc;
  compensation::Snapshot nothing;
  nothing.unserved = refused_;
  const bool published = board_.publish(serving_ ? snapshot_of(followed_.at(*serving_), built_at_)
                                                 : std::move(nothing));
  if (published) watchers_.publish();
}

Awaitable<void> Serving::rebuild_for_ever() {
  const auto period = nanoseconds_from_s(std::max(0.1, description_.serving.rebuild_period_s));
  while (!ending_) {
    if (serving_) rebuild();
    co_await sleep_unless(clock_, clock_.now().utc + period, ended_);
  }
}

Awaitable<Result<PastTargets>> Serving::past(PastTargetsQuery query) const {
  if (!serving_ && refused_) co_return tl::unexpected(*refused_);
  if (!serving_)
    co_return fail(ErrorCode::failed_precondition, reasons::kNoModel,
                   "no model serves: promote one");
  const Followed& followed = followed_.at(*serving_);
  PastModel from{followed.builder.model(), *serving_, datum_,
                 datum_ && followed.origin.own_datum == datum_->id};
  co_return co_await reader_.call(
      [cell = &description_, now = clock_.now().utc](Store& store, PastModel& model,
                                                     const PastTargetsQuery& asked) {
        return past_targets(store, *cell, std::move(model), asked, now);
      },
      std::move(from), std::move(query));
}

Result<std::vector<double>> Serving::targets(const std::vector<Channel>& coordinates,
                                             const TrajectoryPoint& point,
                                             std::optional<ModelId> model) const {
  if (!model) model = serving_;
  if (!model && refused_) return tl::unexpected(*refused_);
  if (!model)
    return fail(ErrorCode::failed_precondition, reasons::kNoModel,
                "no model serves: promote one, or run without compensation");
  const auto found = followed_.find(*model);
  if (found == followed_.end())
    return fail(ErrorCode::not_found, reasons::kModelNotFollowed,
                fmt::format("model {} is not loaded", model->value));
  const auto now = clock_.now().utc;
  const auto snapshot = snapshot_of(found->second, now);
  compensation::TargetRequest request;
  request.now = now;
  request.with_uncertainty = false;
  request.show_unreachable = true;  // whoever moves there checks the limits, and names the row
  for (std::size_t i = 0; i < coordinates.size(); ++i)
    if (const auto variable = compensation::variable_from(coordinates[i].symbol))
      request.set(*variable, point.target[i]);
  if (point.force_n) request.set(compensation::Variable::force, *point.force_n);
  const auto target = compensation::compute_target(snapshot, request);
  if (target.refusal != compensation::Refusal::none)
    return tl::unexpected(compensation::refusal_error(snapshot, target));
  std::vector<double> q_mm;
  for (const auto& axis : description_.motor_channels()) {
    std::size_t output = 0;
    while (output < target.outputs && snapshot.outputs[output].channel != axis) ++output;
    if (output == target.outputs)
      return fail(ErrorCode::failed_precondition, reasons::kNotAllAxes,
                  fmt::format("model {} gives no {}: fit all motor coordinates", model->value,
                              axis.name()));
    q_mm.push_back(target.q_mm[output]);
  }
  return q_mm;
}

std::shared_ptr<void> Serving::watch_snapshots(std::function<void()> on_rebuilt) {
  on_rebuilt();
  return watchers_.add(std::move(on_rebuilt));
}

}  // namespace driftwise::application
