#pragma once
// A database in a folder of its own, and examples of what a run stores.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "storage/sqlite/database.h"
#include "storage/sqlite_store.h"

namespace driftwise::storage {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    // In memory where the system has such a folder: what a sync does is the business of
    // tests/faults.
    const std::filesystem::path parent =
        std::filesystem::exists("/dev/shm") ? "/dev/shm" : std::filesystem::temp_directory_path();
    std::string name = (parent / "driftwise-store-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

inline std::unique_ptr<Store> open_store(const std::string& path, bool read_only = false,
                                         const SqliteOptions& options = {}) {
  auto store = open_sqlite_store(path, read_only, options);
  if (!store) throw std::runtime_error(store.error().message);
  return *std::move(store);
}

// The database that driftwised 0.1.0 (schema version 1) left of a whole cell's work.
inline std::string copy_of_version_1_cell(const TemporaryFolder& folder) {
  std::ifstream file(DRIFTWISE_SOURCE_DIR "/tests/data/databases/version_1_cell.sql");
  std::stringstream sql;
  sql << file.rdbuf();
  EXPECT_FALSE(sql.str().empty());
  std::string path = folder / "version_1.db";
  Database(path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, "").execute(sql.str());
  return path;
}

constexpr std::int64_t kStartNs = 1'790'000'000'000'000'000;  // 2026-09-21T14:13:20Z
inline Stamp at_s(double seconds) {
  const Nanoseconds since = nanoseconds_from_s(seconds);
  return {{kStartNs + since.count()}, since.count()};
}

inline NewRun example_run(const std::string& name = "case A") {
  return {.name = name,
          .trajectory_name = "plan.csv",
          .trajectory_text = "q1_mm\n0\n1\n",
          .rows = 1008,
          .rules_json = R"({"readings_per_point":4})",
          .config_hash = "c0ffee",
          .config_text = "[cell]\nname = \"linear-axis\"\n",
          .operator_name = "ada",
          .request_id = "",
          .created = at_s(0)};
}

inline DatumRecord example_datum(RunId run, double seconds = 1) {
  return {
      .id = {},
      .run = run,
      .opened = at_s(seconds),
      .reason = "start",
      .values = {
          {"q1_mm", 0.00002}, {"x_mm", -0.000013}, {"t01_degC", 20.503}, {"t02_degC", kMissing}}};
}

// What one point of the linear axis changes: four readings of the interferometer and of the scale,
// one scan.
inline PointCommit example_commit(RunId run, DatumId datum, std::int64_t row, int readings = 4) {
  const double t = 10.0 + 14.0 * static_cast<double>(row);
  const double q = static_cast<double>(row % 18);
  PointCommit commit;
  commit.run = run;
  AttemptRecord attempt{.row = row,
                        .number = 1,
                        .verdict = Verdict::accepted,
                        .reason = "",
                        .started = at_s(t),
                        .ended = at_s(t + 3),
                        .spread_nm = 2.5,
                        .readings = {}};
  for (int i = 0; i < readings; ++i) {
    const Stamp from = at_s(t + 2 + 0.1 * i), to = at_s(t + 2.05 + 0.1 * i);
    attempt.readings.push_back({"laser-x",
                                from.utc,
                                to.utc,
                                row * readings + i,
                                {{"x_mm", q + 1e-6 * i}, {"x_std_nm", 1.2}}});
    attempt.readings.push_back(
        {"axis", from.utc, to.utc, row * readings + i, {{"q1_mm", q + 2.5e-5}}});
  }
  commit.attempts.push_back(attempt);
  Reading scan{"scanner", at_s(t).utc, at_s(t + 0.8).utc, row, {}};
  for (int i = 1; i <= 9; ++i)
    scan.values.push_back({"t0" + std::to_string(i) + "_degC", 20.5 + 0.01 * i});
  commit.slow_readings.push_back(scan);
  commit.moves.push_back({run, at_s(t), {q - 1}, {q}, "point"});
  PointRecord point;
  point.run = run;
  point.row = row;
  point.datum = datum;
  point.set = row % 2 == 0 ? PointSet::calibration : PointSet::validation;
  point.line = row / 18;
  point.zero = row % 18 == 0;
  point.measured = at_s(t + 2.2);
  point.dwell_s = 2.2;
  point.commanded_mm = {q};
  point.values = {{"q1_mm", q + 2.5e-5}, {"x_mm", q + 1.5e-6}, {"x_std_nm", 2.5}};
  for (const auto& value : scan.values) point.values.push_back(value);
  commit.point = point;
  commit.place.next_row = row + 1;
  return commit;
}

inline double value_of(const std::vector<ChannelValue>& values, const std::string& channel) {
  for (const auto& value : values)
    if (value.channel == channel) return value.value;
  ADD_FAILURE() << "no channel " << channel;
  return kMissing;
}

// A store with one running run and its datum.
class StoreTest : public testing::Test {
 protected:
  StoreTest() {
    store = open_store(path);
    run = store->runs().create_run(example_run()).value().id;
    RunChange running;
    running.state = RunState::running;
    running.started = at_s(0.5).utc;
    EXPECT_TRUE(store->runs().change_run(run, running));
    datum = store->points().open_datum(example_datum(run)).value();
  }
  void reopen() {
    store.reset();
    store = open_store(path);
  }

  TemporaryFolder folder;
  std::string path = folder / "cell.db";
  std::unique_ptr<Store> store;
  RunId run;
  DatumId datum;
};

}  // namespace driftwise::storage
