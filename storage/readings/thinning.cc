#include "storage/readings/thinning.h"

#include <algorithm>
#include <array>
#include <utility>

#include "server/core/channel.h"
#include "server/core/reasons.h"

namespace driftwise::storage {
namespace {

struct RawReading {
  std::int64_t id, device, start_ns, end_ns;
  std::int64_t middle_ns() const { return start_ns + (end_ns - start_ns) / 2; }
};
struct RawValue {
  std::int64_t channel;
  double value;  // NaN: missing
};
struct Reduced {
  std::int64_t count = 0;
  double sum = 0, min = 0, max = 0;
  void add(double value) {
    if (is_missing(value)) return;
    min = count == 0 ? value : std::min(min, value);
    max = count == 0 ? value : std::max(max, value);
    sum += value;
    ++count;
  }
  double value(const std::string& reducer) const {
    if (count == 0) return kMissing;
    if (reducer == "min") return min;
    if (reducer == "max") return max;
    return sum / static_cast<double>(count);
  }
};
struct Interval {
  std::int64_t start_ns = 0, end_ns = 0;
  std::vector<std::int64_t> readings;
  std::map<std::int64_t, Reduced> channels;
};
using IntervalKey = std::pair<std::int64_t, std::int64_t>;  // device, multiple of the length

bool is_of_environment(const std::string& channel) {
  constexpr std::array kUnits = {"degC", "K", "Pa", "hPa", "pct"};
  const auto parsed = parse_robot_channel(channel);
  return parsed && std::ranges::find(kUnits, parsed->unit) != kUnits.end();
}

void check_order(const ThinningOrder& order) {
  if (!is_reducer(order.reducer))
    throw_failure(
        ErrorCode::invalid_argument, reasons::kBadReducer,
        "reducer: found '" + order.reducer.substr(0, 64) + "', expected mean, min or max");
  constexpr std::int64_t kSecond = 1'000'000'000;
  if (order.every_ns < kSecond || order.every_ns > 3600 * kSecond)
    throw_failure(ErrorCode::invalid_argument, reasons::kBadRange,
                  "every: expected an interval of 1 s to 1 h");
}

// Reads what a step looks at.
class Looking {
 public:
  explicit Looking(Session& session) : session_(session) {}

  // Readings after one that are in the series already, the newest of all left out.
  std::vector<RawReading> next(std::int64_t after, std::int64_t limit) {
    Query query(session_.db,
                "SELECT reading_id, device_id, start_ns, end_ns, attempt_id FROM reading WHERE "
                "reading_id > ?1 AND reading_id <= (SELECT reading_id FROM series_mark) AND "
                "reading_id < (SELECT max(reading_id) FROM reading) ORDER BY reading_id LIMIT ?2");
    query.bind(after, limit);
    std::vector<RawReading> out;
    looked_ = after;
    count_ = 0;
    while (query.row()) {
      ++count_;
      looked_ = query.integer(0);
      if (query.is_null(4))
        out.push_back({query.integer(0), query.integer(1), query.integer(2), query.integer(3)});
    }
    return out;
  }
  std::int64_t looked() const { return looked_; }
  bool at_end(std::int64_t limit) const { return count_ < limit; }

  // Values of a reading; none: it is not of the environment, or a value of it was rejected.
  std::vector<RawValue> values(const RawReading& reading) {
    Query rejected(session_.db,
                   "SELECT 1 FROM rejected_value WHERE device_id = ? AND start_ns = ? LIMIT 1");
    if (rejected.bind(reading.device, reading.start_ns).row()) return {};
    Query query(session_.db, "SELECT channel_id, value FROM reading_value WHERE reading_id = ?");
    query.bind(reading.id);
    std::vector<RawValue> out;
    while (query.row()) {
      if (!is_environment(query.integer(0))) return {};
      out.push_back({query.integer(0), query.real(1)});
    }
    return out;
  }

 private:
  bool is_environment(std::int64_t channel) {
    const auto known = environment_.find(channel);
    if (known != environment_.end()) return known->second;
    return environment_[channel] = is_of_environment(session_.names.channel_name(channel));
  }

  Session& session_;
  std::map<std::int64_t, bool> environment_;
  std::int64_t looked_ = 0, count_ = 0;
};

// The samples of the removed readings leave the whole values of the series, what an interval became
// takes their place. The summaries above stay: they are those of all readings.
class SeriesChange {
 public:
  void remove(std::int64_t channel, std::int64_t at_ns, double value) {
    blocks_[place(channel, at_ns)].first.push_back({at_ns, value});
  }
  void add(std::int64_t channel, std::int64_t at_ns, double value) {
    blocks_[place(channel, at_ns)].second.push_back({at_ns, value});
  }
  void apply(Session& session) {
    for (auto& [key, change] : blocks_) apply(session, key.first, key.second, change);
  }

 private:
  using Change = std::pair<std::vector<Sample>, std::vector<Sample>>;
  static std::pair<std::int64_t, std::int64_t> place(std::int64_t channel, std::int64_t at_ns) {
    return {channel, floor_to(at_ns, kRawBlockNs)};
  }
  static void apply(Session& session, std::int64_t channel, std::int64_t start_ns, Change& change) {
    std::string data;
    {
      Query present(session.db,
                    "SELECT data FROM series_block WHERE channel_id = ? AND level = 0 AND "
                    "start_ns = ?");
      if (present.bind(channel, start_ns).row()) data = present.bytes(0);
    }
    std::multimap<std::int64_t, double> gone;  // by the microsecond: the block's unit of time
    for (const Sample& one : change.first) gone.emplace((one.at_ns - start_ns) / 1000, one.value);
    std::vector<Sample> stay;
    for (const Sample& one : samples_of(data, start_ns)) {
      auto [at, end] = gone.equal_range((one.at_ns - start_ns) / 1000);
      while (at != end && at->second != one.value) ++at;
      if (at == end)
        stay.push_back(one);
      else
        gone.erase(at);
    }
    const std::string after = add_samples(add_samples({}, start_ns, stay), start_ns, change.second);
    Query(session.db,
          "INSERT INTO series_block (channel_id, level, start_ns, data) VALUES (?, 0, ?, ?) ON "
          "CONFLICT (channel_id, level, start_ns) DO UPDATE SET data = excluded.data")
        .bind(channel, start_ns, Bytes{after})
        .run();
  }

  std::map<std::pair<std::int64_t, std::int64_t>, Change> blocks_;
};

std::int64_t add_thinning(Session& session, const ThinningOrder& order,
                          const std::vector<std::int64_t>& readings) {
  Query next(session.db, "SELECT coalesce(max(thinning_id), 0) + 1 FROM thinning");
  next.row();
  const std::int64_t id = next.integer(0);
  const std::string hash = session.at_commit->thin(id, readings);
  Query(session.db,
        "INSERT INTO thinning (thinning_id, at_ns, at_monotonic_ns, who, proof, peer, reducer, "
        "every_ns, first_reading_id, last_reading_id, reading_count, hash) VALUES (?, ?, ?, ?, ?, "
        "?, ?, ?, ?, ?, ?, ?)")
      .bind(id, order.at.utc.utc_ns, order.at.monotonic_ns, order.by.name, order.by.proof,
            order.by.from, order.reducer, order.every_ns, readings.front(), readings.back(),
            static_cast<std::int64_t>(readings.size()), Bytes{hash})
      .run();
  return id;
}

}  // namespace

ThinningStep thin_readings(Session& session, const ThinningOrder& order, KeptStretches& kept) {
  check_order(order);
  if (order.after_id == 0) kept.forget();
  kept.read_on(session);
  const std::int64_t before_ns = floor_to(order.before.utc_ns, order.every_ns);
  Looking looking(session);
  ThinningStep step;
  // An interval is not cut in two: the last one of a step waits for the next. One that is longer
  // than a step makes the step longer.
  for (std::int64_t limit = kLookedPerStep;; limit *= 2) {
    auto found = looking.next(order.after_id, limit);
    step.looked_id = looking.looked();
    // Readings come in the order of their time: at the first that is too new the rest is, too, and
    // a later order goes on from there.
    const auto is_new = [&](const RawReading& one) { return one.end_ns >= before_ns; };
    const auto first_new = std::ranges::find_if(found, is_new);
    const bool meets_new = first_new != found.end();
    if (meets_new) step.looked_id = first_new->id - 1;
    std::erase_if(found, is_new);
    const bool at_end = meets_new || looking.at_end(limit);
    step.more = !at_end;
    if (found.empty()) return step;
    if (!at_end) {
      const auto last = std::ranges::max(found, {}, &RawReading::start_ns);
      const std::int64_t open_ns = floor_to(last.start_ns, order.every_ns);
      const auto waits = [&](const RawReading& one) { return one.start_ns >= open_ns; };
      step.looked_id = std::ranges::find_if(found, waits)->id - 1;
      if (step.looked_id <= order.after_id) continue;
      std::erase_if(found, [&](const RawReading& one) { return one.id > step.looked_id; });
    }
    std::map<IntervalKey, Interval> intervals;
    std::map<std::int64_t, std::vector<RawValue>> values;
    for (const RawReading& one : found) {
      if (kept.is_within(one.start_ns, one.end_ns)) continue;
      auto held = looking.values(one);
      if (held.empty()) continue;
      Interval& interval =
          intervals[{one.device, floor_to(one.start_ns, order.every_ns) / order.every_ns}];
      interval.start_ns =
          interval.readings.empty() ? one.start_ns : std::min(interval.start_ns, one.start_ns);
      interval.end_ns = std::max(interval.end_ns, one.end_ns);
      interval.readings.push_back(one.id);
      for (const RawValue& value : held) interval.channels[value.channel].add(value.value);
      values.emplace(one.id, std::move(held));
    }
    // One reading in an interval is as short as what would replace it.
    std::erase_if(intervals, [](const auto& one) { return one.second.readings.size() < 2; });
    std::vector<std::int64_t> gone;
    for (const auto& [key, interval] : intervals)
      gone.insert(gone.end(), interval.readings.begin(), interval.readings.end());
    if (gone.empty()) return step;
    std::ranges::sort(gone);
    const std::int64_t thinning = add_thinning(session, order, gone);
    SeriesChange series;
    Query row(session.db,
              "INSERT INTO thinned_value (thinning_id, device_id, start_ns, channel_id, end_ns, "
              "count, value) VALUES (?, ?, ?, ?, ?, ?, ?)");
    for (const auto& [key, interval] : intervals)
      for (const auto& [channel, reduced] : interval.channels) {
        const double value = reduced.value(order.reducer);
        row.bind(thinning, key.first, interval.start_ns, channel, interval.end_ns, reduced.count,
                 value)
            .run();
        if (!is_missing(value))
          series.add(channel, interval.start_ns + (interval.end_ns - interval.start_ns) / 2, value);
      }
    Query delete_values(session.db, "DELETE FROM reading_value WHERE reading_id = ?");
    Query delete_reading(session.db, "DELETE FROM reading WHERE reading_id = ?");
    for (const RawReading& one : found) {
      if (!std::ranges::binary_search(gone, one.id)) continue;
      for (const RawValue& value : values.at(one.id))
        if (!is_missing(value.value)) series.remove(value.channel, one.middle_ns(), value.value);
      delete_values.bind(one.id).run();
      delete_reading.bind(one.id).run();
    }
    series.apply(session);
    step.readings = static_cast<std::int64_t>(gone.size());
    step.intervals = static_cast<std::int64_t>(intervals.size());
    return step;
  }
}

void read_thinned(Session& session, std::int64_t device, CellTime from, CellTime to, int limit,
                  std::vector<Reading>& into) {
  Query query(session.db,
              "SELECT thinning_id, start_ns, end_ns, channel_id, value FROM thinned_value WHERE "
              "device_id = ? AND start_ns >= ? AND start_ns < ? ORDER BY start_ns DESC, "
              "thinning_id DESC, channel_id DESC");  // the index backwards: nothing is sorted
  query.bind(device, from.utc_ns, to.utc_ns);
  std::pair<std::int64_t, std::int64_t> last{-1, -1};
  const auto first = std::ssize(into);
  while (query.row()) {
    const std::pair<std::int64_t, std::int64_t> place{query.integer(1), query.integer(0)};
    if (place != last) {
      if (limit > 0 && std::ssize(into) - first == limit) break;
      into.push_back(
          {session.names.device_name(device), {query.integer(1)}, {query.integer(2)}, 0, {}});
    }
    last = place;
    into.back().values.push_back({session.names.channel_name(query.integer(3)), query.real(4)});
  }
  std::reverse(into.begin() + first, into.end());
  for (auto one = into.begin() + first; one != into.end(); ++one) std::ranges::reverse(one->values);
}

std::map<std::int64_t, std::vector<Sample>> thinned_samples(Session& session) {
  Query query(session.db,
              "SELECT channel_id, start_ns + (end_ns - start_ns) / 2, value FROM thinned_value "
              "WHERE value IS NOT NULL");
  std::map<std::int64_t, std::vector<Sample>> out;
  while (query.row()) out[query.integer(0)].push_back({query.integer(1), query.real(2)});
  return out;
}

}  // namespace driftwise::storage
