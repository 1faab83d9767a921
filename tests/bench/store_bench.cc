// What a point costs in the store, against one bare durable SQLite commit (one row of one number,
// WAL, synchronous FULL) on the same disk. Both are measured in turn, in seven pairs of blocks; the
// ratio is the median of the pairs.
//
//   store_bench [folder]      prints one JSON object; the folder says which disk (default: the
//   current one)
//
// Both with the entry of the chain that each commit appends. A group: what the recorder stores of
// one scan, 3 readings of 10 channels. A point: one attempt of 4 interferometer readings and 4
// readbacks, one scan of 9 temperatures, one move, the joined point: 12 channels. Pin it: taskset
// -c 1 store_bench

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
using storage::at_s;

constexpr int kPairs = 7, kPerBlock = 200;

double microseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

double quantile(std::vector<double> values, double p) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(p * static_cast<double>(values.size() - 1))];
}

struct Cell {
  std::unique_ptr<Store> store;
  RunId run;
  DatumId datum;
  explicit Cell(const std::string& path) : store(storage::open_store(path)) {
    run = store->runs().create_run(storage::example_run()).value().id;
    datum = store->points().open_datum(storage::example_datum(run)).value();
  }
};

std::vector<Reading> scan_at(int s) {
  std::vector<Reading> group;
  for (int device = 0; device < 3; ++device) {
    Reading reading{"scanner-" + std::to_string(device), at_s(s).utc, at_s(s + 0.8).utc, s, {}};
    for (int i = 0; i < 10; ++i)
      reading.values.push_back(
          {"t" + std::to_string(10 * device + i) + "_degC", 20.0 + 1e-7 * (s * 31 % 9973)});
    group.push_back(std::move(reading));
  }
  return group;
}

// Bare and store in turn, point by point, so that both meet the same disk.
nlohmann::ordered_json commit_ratio(const std::string& folder) {
  storage::Database bare(folder + "/bare.db", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, "");
  bare.execute(
      "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; CREATE TABLE t (v REAL) STRICT");
  Cell cell(folder + "/cell.db");
  std::vector<double> ratios, fastest, bare_us, store_us, all_us, idle_us;
  std::int64_t row = 0;
  for (int pair = 0; pair < kPairs; ++pair) {
    std::vector<double> bare_block, store_block;
    for (int i = 0; i < kPerBlock; ++i, ++row) {
      auto begin = Clock::now();
      storage::Query(bare, "INSERT INTO t (v) VALUES (?)")
          .bind(static_cast<double>(row) + 0.5)
          .run();
      bare_block.push_back(microseconds_since(begin));

      const PointCommit commit = storage::example_commit(cell.run, cell.datum, row);
      begin = Clock::now();
      if (!cell.store->points().commit(commit)) throw std::runtime_error("commit failed");
      store_block.push_back(microseconds_since(begin));
      begin = Clock::now();
      if (!cell.store->idle()) throw std::runtime_error("idle failed");
      idle_us.push_back(microseconds_since(begin));
    }
    bare_us.push_back(median(bare_block));
    store_us.push_back(median(store_block));
    ratios.push_back(store_us.back() / bare_us.back());
    fastest.push_back(quantile(store_block, 0.1) / quantile(bare_block, 0.1));
    all_us.insert(all_us.end(), store_block.begin(), store_block.end());
  }
  return {{"bare_commit_us", median(bare_us)},
          {"point_commit_us", median(store_us)},
          {"point_commit_p99_us", quantile(all_us, 0.99)},
          {"ratio", median(ratios)},
          {"ratio_of_fastest_tenth", median(fastest)},  // where other programs keep the disk busy
          {"ratio_of_pairs", ratios},
          {"checkpoint_max_us", quantile(idle_us, 1.0)}};
}

// The same of the recorder's groups.
nlohmann::ordered_json group_ratio(const std::string& folder) {
  storage::Database bare(folder + "/bare_group.db", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, "");
  bare.execute(
      "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; CREATE TABLE t (v REAL) STRICT");
  const std::string path = folder + "/group.db";
  const auto store = storage::open_store(path);
  std::vector<double> ratios, bare_us, store_us;
  int scan = 0;
  for (int pair = 0; pair < kPairs; ++pair) {
    std::vector<double> bare_block, store_block;
    for (int i = 0; i < kPerBlock; ++i, ++scan) {
      auto begin = Clock::now();
      storage::Query(bare, "INSERT INTO t (v) VALUES (?)").bind(scan + 0.5).run();
      bare_block.push_back(microseconds_since(begin));
      const auto group = scan_at(scan);
      begin = Clock::now();
      if (!store->readings().append(group, {})) throw std::runtime_error("append failed");
      store_block.push_back(microseconds_since(begin));
      if (!store->idle()) throw std::runtime_error("idle failed");
    }
    bare_us.push_back(median(bare_block));
    store_us.push_back(median(store_block));
    ratios.push_back(store_us.back() / bare_us.back());
  }
  storage::Database db(path, SQLITE_OPEN_READONLY, "");
  double chain_bytes = 0;
  db.for_each_row("SELECT avg(length(bytes)) FROM chain WHERE what = 'rows'",
                  [&](const std::string& text) { chain_bytes = std::stod(text); });
  const auto begin = Clock::now();
  const auto report = store->audit().verify({}, {});
  if (!report || !report->intact()) throw std::runtime_error("the chain does not hold");
  return {{"bare_commit_us", median(bare_us)},
          {"group_commit_us", median(store_us)},
          {"ratio", median(ratios)},
          {"ratio_of_pairs", ratios},
          {"chain_bytes_per_group", chain_bytes},
          {"verify_rows", report->rows},
          {"verify_seconds", microseconds_since(begin) * 1e-6}};
}

nlohmann::ordered_json queries(const std::string& folder) {
  const auto store = storage::open_store(folder + "/cell.db", true);
  const RunId run = store->runs().runs(1, 0)->at(0).id;
  const auto timed = [](auto&& query) {
    std::vector<double> us;
    for (int i = 0; i < 15; ++i) {
      const auto begin = Clock::now();
      query();
      us.push_back(microseconds_since(begin));
    }
    return median(us) / 1000;
  };
  const std::vector<RunId> runs = {run};
  std::size_t rows = 0, readings = 0;
  const double dataset_ms = timed([&] { rows = store->runs().dataset(runs)->rows; });
  const double series_ms = timed([&] {
    readings =
        store->readings().readings("scanner", at_s(1000).utc, at_s(1000 + 14 * 100).utc, 0)->size();
  });
  return {{"dataset_rows", rows},
          {"dataset_ms", dataset_ms},
          {"series_readings", readings},
          {"series_ms", series_ms}};
}

// 60 hours of 30 channels at 1 Hz, the recorder's way: three devices, a transaction every 10 s.
nlohmann::ordered_json long_run(const std::string& folder, int hours) {
  const std::string path = folder + "/long.db";
  const auto begin = Clock::now();
  {
    const auto store = storage::open_store(path);
    std::vector<Reading> waiting;
    for (int s = 0; s < hours * 3600; ++s) {
      for (Reading& reading : scan_at(s)) waiting.push_back(std::move(reading));
      if (s % 10 != 9) continue;
      if (!store->readings().append(waiting, {}) || !store->idle())
        throw std::runtime_error("append failed");
      waiting.clear();
    }
  }
  return {{"hours", hours},
          {"megabytes", static_cast<double>(std::filesystem::file_size(path)) / 1e6},
          {"seconds", microseconds_since(begin) * 1e-6}};
}

}  // namespace

int main(int argc, char** argv) {
  const std::string parent = argc > 1 ? argv[1] : ".";
  const std::string folder = parent + "/store_bench.tmp";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  nlohmann::ordered_json result = {{"schema", "driftwise.store_bench.v1"},
                                   {"sqlite", sqlite3_libversion()}};
  result["commit"] = commit_ratio(folder);
  result["group"] = group_ratio(folder);
  result["query"] = queries(folder);
  result["recorder"] = long_run(folder, argc > 2 ? std::stoi(argv[2]) : 1);
  std::filesystem::remove_all(folder);
  std::printf("%s\n", result.dump(2).c_str());
  return 0;
}
