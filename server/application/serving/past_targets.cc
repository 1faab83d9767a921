#include "server/application/serving/past_targets.h"

#include <algorithm>
#include <utility>

#include "server/application/serving/memory.h"
#include "server/compensation/correction_parts.h"
#include "server/compensation/snapshot_builder.h"
#include "server/core/try.h"

namespace driftwise::application {
namespace {

constexpr Nanoseconds kReadBack = std::chrono::hours(6);  // in the same means as the answer

std::vector<ChannelValue> values_of(const SeriesAnswer& series, std::size_t bucket) {
  std::vector<ChannelValue> out;
  for (const auto& column : series.columns)
    if (column.count[bucket] > 0) out.push_back({column.channel, column.mean[bucket]});
  return out;
}

// The datum counts from its zero, where effects with memory stood as the readings before it say.
Result<void> anchor(Store& store, const CellDescription& cell, const DatumRecord& datum,
                    compensation::SnapshotBuilder& builder) {
  auto at_zero = builder;
  if (builder.memory() > Nanoseconds(0)) {
    const MemoryQuery query{builder.observed_channels(), builder.memory(), {}};
    DRIFTWISE_TRY(const auto readings,
                  readings_for_memory(store, cell, query, datum.opened.utc + Nanoseconds(1)));
    for (const auto& reading : readings)
      if (reading.middle() <= datum.opened.utc) at_zero.observe(reading);
  }
  DRIFTWISE_RETURN_IF_ERROR(at_zero.anchor(datum.values));
  builder.keep_anchor_of(at_zero);
  return {};
}

// kMissing where nothing was measured: a gap is a gap.
void add_instant(const compensation::Snapshot& snapshot, compensation::TargetRequest request,
                 bool measured, PastTargets& out) {
  request.now = CellTime{};  // how old it is, is known
  request.with_uncertainty = false;
  out.at.push_back(snapshot.built_at);
  // A geometry has no straight kinematics to differ from: nothing is searched for.
  const bool asked = measured && !snapshot.geometry;
  const auto target =
      asked ? compensation::compute_target(snapshot, request) : compensation::Target{};
  const bool known = asked && target.refusal == compensation::Refusal::none && target.missing == 0;
  for (std::size_t i = 0; i < out.tracks.size(); ++i) {
    const auto parts = known ? compensation::correction_parts(snapshot, request, i) : std::nullopt;
    out.tracks[i].correction_nm.push_back(parts ? parts->sum_nm() : kMissing);
  }
}

}  // namespace

Result<PastTargets> past_targets(Store& store, const CellDescription& cell, PastModel from,
                                 const PastTargetsQuery& query, CellTime now) {
  DRIFTWISE_TRY(auto builder,
                compensation::SnapshotBuilder::create(std::move(from.model), from.id, cell));
  if (from.own_datum) {
    builder.keep_model_datum();
  } else if (from.datum) {
    DRIFTWISE_RETURN_IF_ERROR(anchor(store, cell, *from.datum, builder));
  }
  PastTargets out;
  out.model = from.id;
  const auto empty = builder.build(now);
  const auto asked = compensation::compute_target(empty, query.pose);
  if (asked.refusal == compensation::Refusal::missing_coordinate ||
      asked.refusal == compensation::Refusal::not_finite)
    return tl::unexpected(compensation::refusal_error(empty, asked));
  for (const auto& output : empty.outputs) out.tracks.push_back({output.channel, {}});

  SeriesQuery wanted;
  wanted.channels = builder.slow_channels();
  if (wanted.channels.empty()) return out;
  wanted.from = now - query.past - kReadBack;
  if (builder.memory() > kReadBack) {
    DRIFTWISE_TRY(const auto before,
                  means_for_memory(store, wanted.channels, now - query.past - builder.memory(),
                                   wanted.from, kMemoryMeans));
    for (const auto& reading : before) builder.observe(reading);
  }
  wanted.to = now;
  const double share =
      static_cast<double>(kReadBack.count()) / static_cast<double>(query.past.count());
  wanted.buckets = static_cast<int>(query.count * (1 + share));
  DRIFTWISE_TRY(const auto series, store.series().series(wanted));
  const std::size_t buckets = series.columns.empty() ? 0 : series.columns.front().count.size();
  for (std::size_t b = 0; b < buckets; ++b) {
    const CellTime middle =
        series.from + series.bucket * static_cast<std::int64_t>(b) + series.bucket / 2;
    if (middle > now) break;
    const auto values = values_of(series, b);
    builder.observe(values, middle);
    if (middle >= now - query.past)
      add_instant(builder.build(middle), query.pose, !values.empty(), out);
  }
  return out;
}

}  // namespace driftwise::application
