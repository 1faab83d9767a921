// Homing by hand on the wire: the simulated controller references its axes, which then count from
// somewhere else by some nanometres; a new datum is opened, and what is served counts from it.

#include <gmock/gmock.h>

#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

double true_end_effector_nm(const CellAtWork& cell) {
  const auto answer = cell.control("truth?");
  return nlohmann::json::parse(answer.substr(answer.find('{'))).at("end_effector_nm");
}

double target_mm(const CellAtWork& cell, const std::string& pose, nlohmann::json* whole = nullptr) {
  auto target = cell.ask({"target", pose});
  if (whole != nullptr) *whole = target;
  return target.at("coordinates").at(0).at("position_mm");
}

std::string newest_datum(const CellAtWork& cell, const std::string& what) {
  return cell.sql("SELECT " + what + " FROM datum ORDER BY datum_id DESC LIMIT 1");
}

double zero_on_the_scale_mm(const CellAtWork& cell) {
  return std::stod(
      cell.sql("SELECT value FROM datum_value JOIN channel USING (channel_id) WHERE name = 'q1_mm' "
               "ORDER BY datum_id DESC LIMIT 1"));
}

TEST(Homing, ByHandOpensADatumFromWhichTargetsCount) {
  CellAtWork cell;
  // Targets of one snapshot: temperatures do not move what is compared.
  cell.edit_cell_file("rebuild_period_s = 5.0", "rebuild_period_s = 3600.0");
  cell.start_daemon();
  ASSERT_EQ(cell.end_of(cell.start_run(campaign(4, 8))).at("state"), "done");
  const auto fit = cell.ask({"fit", "--run", "1", "--model", "q ~ x + x^2"});
  cell.say({"model", "promote", std::to_string(fit.at("model_id").get<int>()), "--yes"});
  const auto datums = cell.count("SELECT count(*) FROM datum");
  const double zero_before_mm = zero_on_the_scale_mm(cell);
  const double served_before_mm = target_mm(cell, "x=0");

  const auto homed = cell.cli({"home", "--timeout", "100"}, std::chrono::seconds(120));
  ASSERT_EQ(homed.code, 0) << homed.err << cell.daemon_log();

  EXPECT_EQ(cell.count("SELECT count(*) FROM datum"), datums + 1);
  EXPECT_THAT(newest_datum(cell, "reason"), StartsWith("homed by "));
  EXPECT_EQ(newest_datum(cell, "coalesce(run_id, 'of no run')"), "of no run");
  EXPECT_EQ(cell.events("axes.home"), 1);
  nlohmann::json target;
  const double served_mm = target_mm(cell, "x=0", &target);
  for (const auto& flag : target.at("flags")) EXPECT_NE(flag, "unanchored_datum");
  // The target of pose zero is the new zero, some 50 nm from the one before: by what referencing
  // put there. In its own datum the model says where the zero lies by its fitted constant, which
  // one reading of it differs from by its noise (8 nm).
  EXPECT_NEAR(served_mm, zero_on_the_scale_mm(cell), 1e-9);
  EXPECT_NE(zero_on_the_scale_mm(cell), zero_before_mm);
  EXPECT_NEAR((served_mm - served_before_mm) * 1e6,
              (zero_on_the_scale_mm(cell) - zero_before_mm) * 1e6, 25);

  // And what it means to the robot: a millimetre from the new zero is a millimetre.
  const double at_zero_nm = true_end_effector_nm(cell);
  cell.say({"move", "q1=" + std::to_string(target_mm(cell, "x=1")), "--timeout", "100"});
  EXPECT_NEAR(true_end_effector_nm(cell) - at_zero_nm, 1e6, 500);
  const auto status = cell.say({"status"});
  EXPECT_THAT(status, testing::Not(HasSubstr("home again")));
}

TEST(Homing, WithoutAnInterferometerMovesNothingAndNamesIt) {
  CellAtWork cell;
  cell.start_daemon();
  ASSERT_EQ(cell.end_of(cell.start_run(campaign(2, 4))).at("state"), "done");
  const auto datums = cell.count("SELECT count(*) FROM datum");
  cell.control("fault mute laser-x 1000000 s");
  const auto refused = cell.cli({"home", "--timeout", "100"}, std::chrono::seconds(120));
  EXPECT_NE(refused.code, 0);
  EXPECT_THAT(refused.err, HasSubstr("laser-x"));
  EXPECT_THAT(refused.err, HasSubstr("nothing has moved"));
  EXPECT_EQ(cell.count("SELECT count(*) FROM datum"), datums);
  EXPECT_THAT(cell.say({"status"}), Not(HasSubstr("no datum has been opened since")));
}

}  // namespace
}  // namespace driftwise::tests
