// Costs of long records, each against a floor of bare SQLite on the same file: a page of points, a
// dataset with rows kept out, a step of a thinning, an import.
//
//   record_bench [folder [rows]]      prints one JSON object; rows: 100000
//
// page: 1000 points of 12 values at the end of a run, against the same rows by their numbers.
// excluded: a dataset of which every second row was kept out, one exclusion each ten, against the
// same dataset with none out. thinning: a step behind as many attempts as there are rows, against a
// step of a record without attempts. import: a file of 12 channels, against its bare INSERTs in
// one transaction. Each is the median of five. Pin it: taskset -c 1 record_bench

#include <sqlite3.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "storage/sqlite/database.h"
#include "storage/sqlite_store.h"
#include "tests/unit/storage/store_fixture.h"

namespace {

using namespace driftwise;
using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;
using storage::at_s;

constexpr int kTimes = 5, kChannels = 12, kPage = 1000;

template <class Work>
double median_ms(int times, Work&& work) {
  std::vector<double> ms;
  for (int i = 0; i < times; ++i) {
    const auto begin = Clock::now();
    work(i);
    ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
  }
  std::ranges::sort(ms);
  return ms[ms.size() / 2];
}

template <class T>
T good(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

Json against(double floor_ms, double ms) {
  return {{"floor_ms", floor_ms}, {"ms", ms}, {"ratio", ms / floor_ms}};
}

Dataset file_of(std::size_t rows) {
  Dataset data;
  data.rows = rows;
  for (std::size_t i = 0; i < rows; ++i) data.time_s.push_back(static_cast<double>(i));
  for (int c = 0; c < kChannels; ++c) {
    DatasetColumn column{{"t" + std::to_string(10 + c), "degC"}, {}};
    for (std::size_t i = 0; i < rows; ++i)
      column.values.push_back(20 + 1e-4 * static_cast<double>((i * 31 + 7) % 9973));
    data.columns.push_back(std::move(column));
  }
  return data;
}

RunId imported(Store& store, const Dataset& data, const std::string& name) {
  return good(store.runs().import_dataset(storage::example_run(name), data)).id;
}

Json page(const std::string& path, std::int64_t rows) {
  const auto store = storage::open_store(path, true);
  const RunId run = good(store->runs().runs(1, 0)).at(0).id;
  std::int64_t last = 0;
  for (bool more = true; more;) {
    const auto points = good(store->points().points(run, last, 10'000));
    more = !points.empty();
    if (more) last = points.back().id.value;
  }
  const std::int64_t after = last - std::min<std::int64_t>(kPage, rows);
  storage::Database bare(path, SQLITE_OPEN_READONLY, "");
  const double floor_ms = median_ms(kTimes, [&](int) {
    storage::Query point(bare, "SELECT * FROM point WHERE point_id > ? ORDER BY point_id LIMIT ?");
    storage::Query values(bare, "SELECT channel_id, value FROM point_value WHERE point_id = ?");
    point.bind(after, kPage);
    double sum = 0;
    while (point.row()) {
      values.bind(point.integer(0));
      while (values.row()) sum += values.real(1);
      values.restart();
    }
    if (!(sum > 0)) throw std::runtime_error("nothing was read");
  });
  const double ms =
      median_ms(kTimes, [&](int) { good(store->points().points(run, after, kPage)); });
  return against(floor_ms, ms);
}

Json excluded(const std::string& path, std::int64_t rows) {
  const auto store = storage::open_store(path);
  const RunId run = good(store->runs().runs(1, 0)).at(0).id;
  const std::vector<RunId> runs{run};
  const double floor_ms = median_ms(kTimes, [&](int) { good(store->runs().dataset(runs)); });
  const std::int64_t most = std::min<std::int64_t>(rows, 2000);
  for (std::int64_t first = 0; first + 20 <= most; first += 20) {
    ExclusionRecord out;
    out.run = run;
    out.excluded = true;
    for (std::int64_t row = first; row < first + 20; row += 2) out.rows.push_back(row);
    out.reason = "door open";
    out.at = at_s(1);
    out.who = "ada";
    good(store->remarks().exclude(out));
  }
  return against(floor_ms, median_ms(kTimes, [&](int) { good(store->runs().dataset(runs)); }));
}

double thinning_ms(const std::string& path, std::int64_t attempts) {
  const double readings_from_s = 1e7;
  {
    const auto store = storage::open_store(path);
    const RunId run = good(store->runs().create_run(storage::example_run())).id;
    std::vector<Reading> readings;
    for (int s = 0; s < 60'000; ++s)
      readings.push_back({"scanner",
                          at_s(readings_from_s + s).utc,
                          at_s(readings_from_s + s + 0.5).utc,
                          s,
                          {{"t01_degC", 20 + 1e-5 * s}}});
    good(store->readings().append(readings, {}));
    for (bool more = true; more;) more = good(store->series().summarise());
    static_cast<void>(run);
  }
  {
    storage::Database db(path, SQLITE_OPEN_READWRITE, "");
    db.execute("BEGIN");
    for (std::int64_t row = 0; row < attempts; ++row)
      storage::Query(db,
                     "INSERT INTO attempt (run_id, trajectory_row, number, verdict, reason, "
                     "started_ns, started_monotonic_ns, ended_ns, ended_monotonic_ns, spread_nm) "
                     "VALUES (1, ?1, 1, 'accepted', '', ?2, 0, ?2, 0, 1.0)")
          .bind(row, at_s(10.0 * static_cast<double>(row)).utc.utc_ns)
          .run();
    db.execute("COMMIT");
  }
  const auto store = storage::open_store(path);
  ThinningOrder order{
      at_s(readings_from_s + 1e6).utc, 10'000'000'000, "mean", at_s(2e7), {"ada", "", ""}, 0};
  order.after_id = good(store->audit().thin(order)).looked_id;
  return median_ms(kTimes,
                   [&](int) { order.after_id = good(store->audit().thin(order)).looked_id; });
}

Json import(const std::string& folder, const Dataset& data) {
  int file = 0;
  const double floor_ms = median_ms(3, [&](int) {
    storage::Database bare(folder + "/bare" + std::to_string(file++) + ".db",
                           SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, "");
    bare.execute(
        "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; CREATE TABLE p (id INTEGER PRIMARY "
        "KEY, time_s REAL) STRICT; CREATE TABLE v (id INTEGER, channel INTEGER, value REAL, "
        "PRIMARY KEY (id, channel)) STRICT, WITHOUT ROWID");
    bare.execute("BEGIN IMMEDIATE");
    storage::Query point(bare, "INSERT INTO p (id, time_s) VALUES (?, ?)");
    storage::Query value(bare, "INSERT INTO v (id, channel, value) VALUES (?, ?, ?)");
    for (std::size_t row = 0; row < data.rows; ++row) {
      point.bind(static_cast<std::int64_t>(row), data.time_s[row]).run();
      for (int c = 0; c < kChannels; ++c)
        value
            .bind(static_cast<std::int64_t>(row), c,
                  data.columns[static_cast<std::size_t>(c)].values[row])
            .run();
    }
    bare.execute("COMMIT");
  });
  const auto store = storage::open_store(folder + "/import.db");
  const double ms =
      median_ms(3, [&](int i) { imported(*store, data, "file " + std::to_string(i)); });
  return against(floor_ms, ms);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string folder = std::string(argc > 1 ? argv[1] : ".") + "/record_bench.tmp";
  const std::int64_t rows = argc > 2 ? std::stoll(argv[2]) : 100'000;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const Dataset data = file_of(static_cast<std::size_t>(rows));
  Json result = {{"schema", "driftwise.record_bench.v1"}, {"rows", rows}};
  result["import"] = import(folder, data);
  imported(*storage::open_store(folder + "/page.db"), data, "file");
  result["page"] = page(folder + "/page.db", rows);
  result["excluded"] = excluded(folder + "/page.db", rows);
  const double floor_ms = thinning_ms(folder + "/none.db", 0);
  result["thinning"] = against(floor_ms, thinning_ms(folder + "/attempts.db", rows));
  std::filesystem::remove_all(folder);
  std::printf("%s\n", result.dump(2).c_str());
  return 0;
}
