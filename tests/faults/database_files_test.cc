// The database's files under the daemon itself: what it has told is there, whatever is deleted,
// moved or damaged, and a large record does not delay a start.

#include <gmock/gmock.h>
#include <sqlite3.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "tests/faults/crash_judge.h"

namespace driftwise::tests {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;

template <class Condition>
bool within(seconds limit, Condition condition) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(milliseconds(20));
  }
  return true;
}

TEST(DatabaseFiles, ADeletedLogAndAKillLoseNoToldPoint) {
  RunningCell cell({.speed = 100, .seed = 3});
  cell.start_daemon();
  const std::int64_t run_id = cell.create_run(crash_trajectory(6, 12)).id();
  PointsByRow acknowledged;
  std::int64_t told = 0;
  for (int round = 0; round < 4; ++round) {
    PointWatcher watcher(cell.channel(), run_id);
    ASSERT_TRUE(within(seconds(60), [&] { return watcher.acknowledged_count() >= told + 3; }));
    // Deleted, and told points afterwards: the last of them is hardly older than the kill.
    fs::remove(cell.database() + "-wal");
    const auto before = watcher.acknowledged_count();
    ASSERT_TRUE(within(seconds(60), [&] { return watcher.acknowledged_count() > before; }));
    cell.kill_daemon();
    watcher.join();
    told = std::max(told, watcher.acknowledged_count());
    EXPECT_GE(left_behind(cell.database()).points, told) << "round " << round;
    for (const auto& [row, seen] : watcher.seen()) acknowledged.emplace(row, seen);
    cell.start_daemon();
  }
  const v1::Run run = cell.wait_until_over(run_id, seconds(120));
  expect_nothing_lost(cell, run, acknowledged);
}

TEST(DatabaseFiles, AMovedDatabaseStopsTheRunAndIsCopied) {
  RunningCell cell({.speed = 100, .seed = 3});
  cell.start_daemon();
  const std::int64_t run_id = cell.create_run(crash_trajectory(6, 12)).id();
  const std::string path = cell.database(), away = cell.folder() + "/away.moved";
  PointWatcher watcher(cell.channel(), run_id);
  ASSERT_TRUE(within(seconds(60), [&] { return watcher.acknowledged_count() >= 3; }));
  fs::rename(path, away);
  std::string text;
  ASSERT_TRUE(within(seconds(60), [&] {
    text = cell.cli({"status"}).out;
    return text.find("is no longer at its path") != std::string::npos &&
           text.find("waiting") != std::string::npos && text.find(".kept-") != std::string::npos;
  })) << text;
  const auto told = watcher.acknowledged_count();
  std::this_thread::sleep_for(milliseconds(500));  // 50 s of cell time
  EXPECT_EQ(watcher.acknowledged_count(), told) << "no point without a place for it";
  std::string kept;
  for (const auto& entry : fs::directory_iterator(cell.folder()))
    if (entry.path().string().find(".kept-") != std::string::npos) kept = entry.path().string();
  ASSERT_NE(kept, "");
  EXPECT_GE(left_behind(kept).points, told);
  fs::rename(away, path);
  const v1::Run run = cell.wait_until_over(run_id, seconds(120));
  watcher.join();
  expect_nothing_lost(cell, run, watcher.seen());
}

TEST(DatabaseFiles, FourDamagedPagesAreNoticed) {
  RunningCell cell({.speed = 200, .seed = 3});
  cell.start_daemon();
  cell.wait_until_over(cell.create_run(crash_trajectory(4, 12)).id(), seconds(120));
  const std::string path = cell.database();
  ASSERT_TRUE(within(seconds(60), [&] {
    return cell.cli({"status"}).out.find("found clean on") != std::string::npos;
  })) << cell.cli({"status"}).out;
  cell.stop_daemon();
  std::vector<std::int64_t> pages;
  // Not what the start itself needs: a start that cannot read that is refused by name.
  for (const char* table : {"reading_value", "datum_value", "attempt", "move"})
    pages.push_back(count_of(
        path, std::string("SELECT rootpage FROM sqlite_schema WHERE name = '") + table + "'"));
  {
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    for (const auto page : pages) {
      file.seekp((page - 1) * 4096);
      file << std::string(64, '\xff');
    }
  }
  cell.start_daemon();
  ASSERT_TRUE(within(seconds(60), [&] {
    return cell.cli({"status"}).out.find("damaged") != std::string::npos;
  })) << cell.cli({"status"}).out;
}

void exec_sql(const std::string& database, const std::string& sql) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(database.c_str(), &db), SQLITE_OK);
  char* problem = nullptr;
  sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &problem);
  EXPECT_EQ(problem, nullptr) << problem;
  sqlite3_free(problem);
  sqlite3_close(db);
}

// Bytes that the process has read so far, by the kernel's count; pages of files that were in memory
// count as well.
std::int64_t bytes_read(pid_t pid) {
  std::ifstream io("/proc/" + std::to_string(pid) + "/io");
  std::string name;
  std::int64_t bytes = -1;
  while (io >> name >> bytes)
    if (name == "rchar:") return bytes;
  return -1;
}

// Processor time of the process so far, s: fields 14 and 15 of stat, proc(5).
double processor_s(pid_t pid) {
  const std::string text = read_file("/proc/" + std::to_string(pid) + "/stat");
  std::istringstream rest(text.substr(text.rfind(')') + 2));
  std::string skipped;
  for (int field = 3; field < 14; ++field) rest >> skipped;
  double user = 0, system = 0;
  rest >> user >> system;
  return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

// What a start costs does not grow with the record. Counted in bytes and processor time, because a
// clock on a busy machine says something else each time.
TEST(DatabaseFiles, AStartDoesNotReadALargeRecord) {
  constexpr std::int64_t kMostBytes = 32 << 20;
  constexpr double kMost_s = 2;
  RunningCell cell({.speed = 10, .seed = 3});
  cell.start_daemon();
  cell.stop_daemon();
  const std::string path = cell.database();
  exec_sql(path,
           "PRAGMA synchronous = OFF; BEGIN;"
           "INSERT OR IGNORE INTO device (name) VALUES ('scanner');"
           "INSERT OR IGNORE INTO channel (name) VALUES ('t01_degC');"
           // Half a million scans, long ago.
           "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 500000)"
           "INSERT INTO reading (reading_id, device_id, start_ns, end_ns, sequence)"
           " SELECT 1000000 + i, (SELECT device_id FROM device WHERE name = 'scanner'),"
           " 1500000000000000000 + i * 5000000000, 1500000001000000000 + i * 5000000000, i FROM n;"
           "INSERT INTO reading_value SELECT reading_id, (SELECT channel_id FROM channel WHERE "
           "name = 't01_degC'), 20.5 FROM reading WHERE reading_id > 1000000;"
           // What people said and what happened, at length.
           "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 200)"
           "INSERT INTO event (at_ns, at_monotonic_ns, who, peer, what, detail)"
           " SELECT 1500000000000000000 + i, i, 'ada', '', 'test', printf('%.*c', 1000000, 'x') "
           "FROM n;"
           "COMMIT; PRAGMA wal_checkpoint(TRUNCATE);");
  const auto size = static_cast<std::int64_t>(fs::file_size(path));
  ASSERT_GT(size, 8 * kMostBytes - (40 << 20)) << "no large record";
  cell.start_daemon();
  const auto read = bytes_read(cell.daemon().pid());
  const double used_s = processor_s(cell.daemon().pid());
  RecordProperty("database_bytes", std::to_string(size));
  RecordProperty("bytes_read", std::to_string(read));
  RecordProperty("processor_s", std::to_string(used_s));
  EXPECT_GT(read, 0);
  EXPECT_LT(read, kMostBytes) << "of " << size;
  EXPECT_LT(used_s, kMost_s);
}

}  // namespace
}  // namespace driftwise::tests
