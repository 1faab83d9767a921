#include "storage/readings/series_store.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>

#include "server/core/try.h"
#include "storage/readings/series_block.h"
#include "storage/readings/series_grid.h"
#include "storage/readings/thinning.h"
#include "storage/rows/run_rows.h"

namespace driftwise::storage {
namespace {

// Values of the readings after one, up to another. Without rejected ones: an infinite or huge
// answer would hide every other value of its plot.
constexpr const char* kSamples =
    "SELECT channel_id, start_ns + (end_ns - start_ns) / 2, value FROM reading JOIN reading_value "
    "USING (reading_id) WHERE reading_id > ? AND reading_id <= ? AND value IS NOT NULL AND NOT "
    "EXISTS (SELECT 1 FROM rejected_value x WHERE x.device_id = reading.device_id AND x.start_ns = "
    "reading.start_ns AND x.sequence = reading.sequence AND x.channel_id = "
    "reading_value.channel_id) ORDER BY reading_id";

using Buckets = std::vector<Bucket>;

std::int64_t read_series_mark(Session& session) {
  Query query(session.db, "SELECT reading_id FROM series_mark");
  return query.row() ? query.integer(0) : 0;
}

std::int64_t newest_reading(Session& session) {
  Query query(session.db, "SELECT coalesce(max(reading_id), 0) FROM reading");
  query.row();
  return query.integer(0);
}

std::optional<std::int64_t> channel_id_of(Session& session, const std::string& name) {
  Query query(session.db, "SELECT channel_id FROM channel WHERE name = ?");
  if (!query.bind(name).row()) return std::nullopt;
  return query.integer(0);
}

void merge_block(Session& session, std::int64_t channel, int level, std::int64_t start,
                 std::span<const Sample> samples) {
  Query present(
      session.db,
      "SELECT data FROM series_block WHERE channel_id = ? AND level = ? AND start_ns = ?");
  present.bind(channel, level, start);
  const std::string before = present.row() ? present.bytes(0) : std::string();
  present.restart();
  const std::string after = level == 0 ? add_samples(before, start, samples)
                                       : add_to_buckets(before, level, start, samples);
  Query(session.db,
        "INSERT INTO series_block (channel_id, level, start_ns, data) VALUES (?, ?, ?, ?) "
        "ON CONFLICT (channel_id, level, start_ns) DO UPDATE SET data = excluded.data")
      .bind(channel, level, start, Bytes{after})
      .run();
}

void add_to_blocks(Session& session, std::int64_t channel, const std::vector<Sample>& samples) {
  for (int level = 0; level <= kSummaryLevels; ++level) {
    std::map<std::int64_t, std::vector<Sample>> blocks;
    for (const Sample& sample : samples)
      blocks[floor_to(sample.at_ns, block_ns(level))].push_back(sample);
    for (const auto& [start, inside] : blocks) merge_block(session, channel, level, start, inside);
  }
}

void read_raw_blocks(Session& session, std::int64_t channel, const SeriesGrid& grid, Buckets& out) {
  Query query(session.db,
              "SELECT start_ns, data FROM series_block WHERE channel_id = ? AND level = 0 AND "
              "start_ns > ? AND start_ns < ?");
  query.bind(channel, grid.from_ns - kRawBlockNs, grid.to_ns());
  while (query.row())
    for (const Sample& sample : samples_of(query.bytes(1), query.integer(0)))
      if (grid.holds(sample.at_ns)) out[grid.index(sample.at_ns)].add(sample.value);
}

void read_summaries(Session& session, std::int64_t channel, const SeriesGrid& grid, Buckets& out) {
  Query query(session.db,
              "SELECT start_ns, data FROM series_block WHERE channel_id = ? AND level = ? AND "
              "start_ns > ? AND start_ns < ?");
  query.bind(channel, grid.level, grid.from_ns - block_ns(grid.level), grid.to_ns());
  while (query.row()) {
    std::int64_t at = query.integer(0);
    for (const Bucket& bucket : buckets_of(query.bytes(1))) {
      if (bucket.count > 0 && grid.holds(at)) out[grid.index(at)].add(bucket);
      at += bucket_ns(grid.level);
    }
  }
}

// What no step has taken in yet: a few hundred readings.
void read_tail(Session& session, const std::map<std::int64_t, Buckets*>& columns,
               const SeriesGrid& grid) {
  Query query(session.db, kSamples);
  query.bind(read_series_mark(session), std::numeric_limits<std::int64_t>::max());
  while (query.row()) {
    const auto column = columns.find(query.integer(0));
    const std::int64_t at = query.integer(1);
    if (column != columns.end() && grid.holds(at))
      (*column->second)[grid.index(at)].add(query.real(2));
  }
}

void read_points_of_run(Session& session, RunId run, std::int64_t channel, const SeriesGrid& grid,
                        Buckets& out) {
  Query query(
      session.db,
      "SELECT measured_ns, value FROM point JOIN point_value USING (point_id) WHERE run_id "
      "= ? AND channel_id = ? AND value IS NOT NULL AND point_id NOT IN (SELECT point_id FROM "
      "passage)");
  query.bind(run, channel);
  while (query.row())
    if (grid.holds(query.integer(0))) out[grid.index(query.integer(0))].add(query.real(1));
}

}  // namespace

Result<SeriesAnswer> SqliteSeriesStore::series(const SeriesQuery& asked) {
  return session_.read([&] {
    if (asked.run) require_run(session_, *asked.run);
    SeriesGrid grid = series_grid(asked.from.utc_ns, asked.to.utc_ns, asked.buckets);
    std::vector<Buckets> columns(asked.channels.size(), Buckets(grid.buckets));
    std::map<std::int64_t, Buckets*> by_channel;
    std::vector<bool> recorded(columns.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const auto channel = channel_id_of(session_, asked.channels[i]);
      recorded[i] = channel.has_value();
      if (!channel) continue;
      by_channel[*channel] = &columns[i];
      if (asked.run)
        read_points_of_run(session_, *asked.run, *channel, grid, columns[i]);
      else if (grid.level == 0)
        read_raw_blocks(session_, *channel, grid, columns[i]);
      else
        read_summaries(session_, *channel, grid, columns[i]);
    }
    if (!asked.run) read_tail(session_, by_channel, grid);
    SeriesAnswer answer;
    answer.from = {grid.from_ns};
    answer.to = {grid.to_ns()};
    answer.bucket = Nanoseconds(grid.bucket_ns);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      answer.columns.push_back(column_of(asked.channels[i], columns[i]));
      answer.columns.back().recorded = recorded[i];
    }
    return answer;
  });
}

Result<void> SqliteSeriesStore::keep_up() {
  DRIFTWISE_TRY(const auto waiting, session_.read([&] {
    return newest_reading(session_) - read_series_mark(session_);
  }));
  if (waiting < kReadingsPerStep / 2) return {};
  const auto done = summarise();
  return done ? Result<void>{} : tl::unexpected(done.error());
}

Result<bool> SqliteSeriesStore::summarise() {
  return session_.write([&] {
    const std::int64_t mark = read_series_mark(session_);
    const std::int64_t last = newest_reading(session_),
                       until = std::min(last, mark + kReadingsPerStep);
    if (until <= mark) return false;
    std::map<std::int64_t, std::vector<Sample>> channels;
    Query query(session_.db, kSamples);
    query.bind(mark, until);
    while (query.row()) channels[query.integer(0)].push_back({query.integer(1), query.real(2)});
    if (mark == 0)
      for (auto& [channel, samples] : thinned_samples(session_))
        channels[channel].insert(channels[channel].end(), samples.begin(), samples.end());
    for (const auto& [channel, samples] : channels) add_to_blocks(session_, channel, samples);
    Query(session_.db, "UPDATE series_mark SET reading_id = ?").bind(until).run();
    return until < last;
  });
}

}  // namespace driftwise::storage
