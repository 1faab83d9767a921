#include "tests/faults/crash_judge.h"

#include <gtest/gtest.h>

#include <cmath>

namespace driftwise::tests {

std::string crash_trajectory(int lines, int per_line) {
  std::string csv = "q1_mm,set,line,zero\n";
  for (int line = 1; line <= lines; ++line)
    for (int i = 0; i < per_line; ++i) {
      const double q_mm = i == 0 ? 0.0 : -2.0 + 4.0 * i / per_line + 0.125 * (line % 2);
      csv += std::to_string(q_mm) + (i % 2 ? ",validation," : ",calibration,") +
             std::to_string(line) + (i == 0 ? ",1\n" : ",0\n");
    }
  return csv;
}

LeftBehind left_behind(const std::string& database) {
  LeftBehind left;
  left.run_id = count_of(database, "SELECT coalesce(max(run_id), 0) FROM run");
  left.points = count_of(database, "SELECT count(*) FROM planned_point");
  left.datums = count_of(database, "SELECT count(*) FROM datum");
  left.state = query_one(database, "SELECT state FROM run_progress ORDER BY run_id DESC LIMIT 1");
  return left;
}

void expect_nothing_lost(RunningCell& cell, const v1::Run& run, const PointsByRow& acknowledged) {
  EXPECT_EQ(run.state(), v1::Run::STATE_DONE) << run.reason();
  EXPECT_EQ(run.accepted_count() + run.given_up_count(), run.row_count());
  const auto points = points_by_row(cell.channel(), run.id());
  EXPECT_EQ(static_cast<std::int64_t>(points.size()), run.accepted_count());
  for (const auto& [row, seen] : acknowledged) {
    const auto found = points.find(row);
    ASSERT_NE(found, points.end()) << "row " << row << " was acknowledged and is gone";
    EXPECT_EQ(found->second.values, seen.values)
        << "row " << row << " changed after it was acknowledged";
  }
  const auto database = cell.database();
  // Two tables speak of accepted points: neither may hold one twice, and they must agree.
  EXPECT_EQ(count_of(database,
                     "SELECT count(*) FROM (SELECT 1 FROM attempt WHERE verdict = 'accepted' "
                     "GROUP BY run_id, trajectory_row HAVING count(*) > 1)"),
            0);
  EXPECT_EQ(count_of(database,
                     "SELECT (SELECT count(*) FROM planned_point) - "
                     "(SELECT count(*) FROM attempt WHERE verdict = 'accepted')"),
            0);
  EXPECT_EQ(query_one(database, "PRAGMA integrity_check"), "ok");
  EXPECT_EQ(query_one(database, "PRAGMA foreign_key_check"), "");
}

void expect_restart_recorded(RunningCell& cell, const v1::Run& run, const LeftBehind& before) {
  if (!before.has_begun()) return;
  const auto database = cell.database();
  EXPECT_EQ(run.restart_count(), 1);
  EXPECT_EQ(count_of(database, "SELECT count(*) FROM event WHERE what = 'run.restarted'"), 1);
  EXPECT_EQ(count_of(database, "SELECT count(*) FROM attempt WHERE verdict = 'interrupted'"),
            before.points < run.row_count() ? 1 : 0);
  EXPECT_EQ(count_of(database, "SELECT count(*) FROM datum"), before.datums + 1);
  EXPECT_EQ(query_one(database, "SELECT reason FROM datum ORDER BY datum_id DESC LIMIT 1"),
            "restart after a kill");
  if (before.datums == 0) return;
  const std::string of_the_last =
      "SELECT value FROM datum_value JOIN channel USING (channel_id) WHERE datum_id = "
      "(SELECT max(datum_id) FROM datum) AND name = ";
  const auto found = query_one(database, of_the_last + "'zero_found_nm'");
  const auto difference = query_one(database, of_the_last + "'zero_difference_nm'");
  ASSERT_NE(found, "");
  ASSERT_NE(difference, "");
  EXPECT_NE(query_one(database, of_the_last + "'zero_predicted_nm'"), "");
  // The mark repeats within a few nm, the axis holds within 35 nm, and the air hardly drifts
  // meanwhile.
  EXPECT_LT(std::abs(std::stod(found)), 200.0);
  EXPECT_LT(std::abs(std::stod(difference)), 200.0);
}

}  // namespace driftwise::tests
