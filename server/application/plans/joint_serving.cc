#include "server/application/plans/joint_serving.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/application/serving/memory.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

constexpr auto kShortestJointRebuild = std::chrono::milliseconds(500);

}  // namespace

JointServing::JointServing(asio::any_io_executor executor, const CellDescription& description,
                           const ConfigurationBook& configuration, Clock& clock, Recorder& recorder,
                           StoreReader& reader, EventLog& events, TaskGroup& tasks,
                           Serving& serving)
    : executor_(executor),
      description_(description),
      configuration_(configuration),
      clock_(clock),
      recorder_(recorder),
      reader_(reader),
      events_(events),
      tasks_(tasks),
      serving_(serving),
      ended_(executor) {}

void JointServing::start() {
  readings_ = recorder_.watchers().add([this](const Reading& reading) { observe(reading); });
  datums_ = serving_.watch_snapshots([this] { on_serving(); });
  tasks_.spawn(rebuild_for_ever());
}

void JointServing::shut_down() {
  ending_ = true;
  ended_.raise();
}

Awaitable<Result<void>> JointServing::serve(PlanId id, plans::ServingPlan plan,
                                            plans::ModelsById models) {
  std::map<ModelId, ModelOrigin> origins;
  for (const auto& [model, content] : models)
    origins[model] = co_await origin_of(content, reader_, description_.hash);
  DRIFTWISE_CO_TRY(auto builder,
                   plans::JointBuilder::create(std::move(plan), id, models, description_));
  std::vector<Reading> readings;
  std::optional<DatumId> datum;
  do {
    datum = serving_.datum() ? std::optional(serving_.datum()->id) : std::nullopt;
    MemoryQuery wanted{builder.observed_channels(), builder.memory(), zero_of(serving_.datum())};
    auto stored = co_await reader_.call(
        [cell = &description_, now = clock_.now().utc](Store& store, const MemoryQuery& query) {
          return readings_for_memory(store, *cell, query, now);
        },
        std::move(wanted));
    readings = stored ? std::move(*stored) : std::vector<Reading>();
  } while (serving_.datum() && serving_.datum()->id != datum);  // zeroed meanwhile
  append_latest(recorder_, readings);
  followed_.emplace(Followed{id, std::move(builder), std::move(origins), {}});
  refused_.reset();
  replay(readings, zero_of(serving_.datum()), followed_->builder, [this] { anchor(); });
  rebuild();
  co_return Result<void>{};
}

void JointServing::serve_none() {
  followed_.reset();
  refused_.reset();
  rebuild();
}

void JointServing::refuse(PlanId id, Error why) {
  events_.record_own("plan.refused",
                     fmt::format("plan {} does not serve: {}", id.value, why.message));
  followed_.reset();
  refused_ = std::move(why);
  rebuild();
}

std::string JointServing::trouble() const {
  if (refused_) return refused_->message;
  return followed_ ? followed_->trouble : std::string();
}

void JointServing::anchor() {
  const auto& datum = serving_.datum();
  if (!followed_ || !datum) return;
  anchored_to_ = datum->id;
  const auto trouble = followed_->builder.anchor(datum->values, [&](ModelId model) {
    return followed_->origins.at(model).own_datum == datum->id;
  });
  followed_->trouble.clear();
  for (const auto& one : trouble)
    followed_->trouble += (followed_->trouble.empty() ? "" : "; ") + one;
  if (!followed_->trouble.empty())
    events_.record_own("plan.unanchored",
                       fmt::format("datum {} does not anchor plan {}: {}", datum->id.value,
                                   followed_->id.value, followed_->trouble));
}

// Another datum, or the question of the cell file was answered.
void JointServing::on_serving() {
  if (!followed_) return;
  const auto& datum = serving_.datum();
  if (datum && anchored_to_ != datum->id) {
    anchor();
    rebuild();
  } else if (configuration_.asks() || clock_.now().utc - built_at_ >= kShortestJointRebuild) {
    rebuild();
  }
}

void JointServing::observe(const Reading& reading) {
  if (!followed_) return;
  followed_->builder.observe(reading);
  if (clock_.now().utc - built_at_ < kShortestJointRebuild) return;
  for (const auto& channel : followed_->builder.slow_channels())
    if (reading.find(channel)) return rebuild();
}

plans::JointSnapshot JointServing::snapshot_now() const {
  plans::JointSnapshot snapshot;
  if (followed_) {
    const bool asks = configuration_.asks();
    snapshot = followed_->builder.build(
        clock_.now().utc, [&](ModelId model, compensation::Snapshot& part) {
          part.doubtful = serving_.is_doubtful(model);
          if (!asks) return;
          part.configuration_changed = true;
          const auto& origin = followed_->origins.at(model);
          if (!origin.under_present) part.changed_parts = configuration_.changes_of(origin.symbols);
        });
  }
  snapshot.unserved = refused_;
  return snapshot;
}

void JointServing::rebuild() {
  auto snapshot = snapshot_now();
  built_at_ = clock_.now().utc;
  static_cast<void>(board_.publish(std::move(snapshot)));  // readers keep it: the next one comes
}

Awaitable<void> JointServing::rebuild_for_ever() {
  const auto period = nanoseconds_from_s(std::max(0.1, description_.serving.rebuild_period_s));
  while (!ending_) {
    if (followed_) rebuild();
    co_await sleep_unless(clock_, clock_.now().utc + period, ended_);
  }
}

}  // namespace driftwise::application
