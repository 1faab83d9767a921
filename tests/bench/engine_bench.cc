// What the run engine and the durable store cost per group of readings (12 channels, 4 readings),
// in bare durable SQLite commits (WAL, synchronous FULL) of a row of 12 numbers on the same disk.
//
//   taskset -c 0 build/release/bin/engine_bench [folder on the disk to measure, default .]
//
// Virtual time and simulated devices: what is left is the engine's own work, its polls, joins and
// events, and the store. The store runs on the engine's thread here, so that the hop between two
// threads is not in the figure. Pairs are interleaved; the figure is the median of seven.

#include <spdlog/spdlog.h>
#include <sqlite3.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "storage/sqlite_store.h"
#include "tests/support/cell_in_memory.h"

namespace {

using namespace driftwise;
using SteadyTime = std::chrono::steady_clock;
constexpr int kPairs = 7;
constexpr int kLines = 40, kPoints = kLines * 6;

double microseconds_since(SteadyTime::time_point begin) {
  return std::chrono::duration<double, std::micro>(SteadyTime::now() - begin).count();
}

double bare_commit_us(const std::string& path) {
  sqlite3* db = nullptr;
  const auto run = [&db](const char* sql) {
    if (sqlite3_exec(db, sql, nullptr, nullptr, nullptr) != SQLITE_OK)
      throw std::runtime_error(sqlite3_errmsg(db));
  };
  if (sqlite3_open(path.c_str(), &db) != SQLITE_OK) throw std::runtime_error("cannot open " + path);
  run("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;"
      "CREATE TABLE g(id INTEGER PRIMARY KEY, a,b,c,d,e,f,g,h,i,j,k,l)");
  sqlite3_stmt* insert = nullptr;
  sqlite3_prepare_v2(db, "INSERT INTO g VALUES(NULL,?,?,?,?,?,?,?,?,?,?,?,?)", -1, &insert,
                     nullptr);
  const auto begin = SteadyTime::now();
  for (int n = 0; n < kPoints; ++n) {
    for (int i = 1; i <= 12; ++i) sqlite3_bind_double(insert, i, n + 0.1 * i);
    sqlite3_step(insert);
    sqlite3_reset(insert);
  }
  const double each = microseconds_since(begin) / kPoints;
  sqlite3_finalize(insert);
  sqlite3_close(db);
  return each;
}

double engine_point_us(const std::string& path) {
  tests::SmallWorld world;
  const OpenStore open = [](const std::string& p, bool read_only) {
    return storage::open_sqlite_store(p, read_only);
  };
  tests::CellInMemory cell(world, tests::small_cell(path), open);
  cell.begin_run(tests::lines_of(kLines, {-4, -2, 1, 3, 4}, true));
  std::int64_t accepted =
      0;  // as a watcher is told: asking for the status at every step would be the figure
  const auto watch =
      cell->runs.watch([&](const application::RunProgress& p) { accepted = p.run.accepted; });
  cell.until([&] { return accepted == 1; });
  const auto begin = SteadyTime::now();
  cell.until([&] { return accepted == kPoints; });
  return microseconds_since(begin) / (kPoints - 1);
}

}  // namespace

int main(int argc, char** argv) {
  spdlog::set_level(spdlog::level::warn);
  const auto folder = std::filesystem::absolute(argc > 1 ? argv[1] : ".") / "engine_bench.tmp";
  std::vector<double> ratios;
  for (int pair = 0; pair < kPairs; ++pair) {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    const double bare_us = bare_commit_us((folder / "bare.sqlite").string());
    const double engine_us = engine_point_us((folder / "cell.sqlite").string());
    ratios.push_back(engine_us / bare_us);
    std::printf("bare commit %7.1f us   engine and store per group %7.1f us   ratio %.2f\n",
                bare_us, engine_us, ratios.back());
  }
  std::filesystem::remove_all(folder);
  std::ranges::sort(ratios);
  std::printf("median ratio %.2f, target at most 2.5\n", ratios[kPairs / 2]);
  return 0;
}
