#include "server/standards/iso9283.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/standards/standards_data.h"

namespace driftwise::standards {
namespace {

using testing::HasSubstr;

TEST(Iso9283, GivesTheFiguresThatRGives) {
  const auto found = iso9283(standards_dataset("iso9283.csv"), {});
  ASSERT_TRUE(found) << found.error().message;
  const auto r = figures_by_r("iso9283");
  ASSERT_EQ(found->poses.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    const auto& pose = found->poses[i];
    const auto at = [&](const char* name) { return r.at(name + std::to_string(i + 1)); };
    EXPECT_EQ(pose.cycles, 30U);
    EXPECT_NEAR(pose.ap_nm, at("AP_"), 1e-8);
    EXPECT_NEAR(pose.ap_axis_nm[0], at("APx_"), 1e-8);
    EXPECT_NEAR(pose.rp_nm, at("RP_"), 1e-8);
    // 648000 arcsec in doubles: 1e-10 each.
    EXPECT_NEAR(pose.ap_rotation_arcsec[0], at("APrx_"), 1e-8) << "across the half turn";
    EXPECT_NEAR(pose.rp_rotation_arcsec[0], at("RPrx_"), 1e-8);
    EXPECT_NEAR(pose.ap_rotation_arcsec[1], at("APry_"), 1e-10) << "commanded 0";
    EXPECT_NEAR(pose.rp_rotation_arcsec[1], at("RPry_"), 1e-10);
  }
  EXPECT_GE(found->worst_rp_nm, found->poses[2].rp_nm);
}

TEST(Iso9283, GivesRepeatabilityAloneWhenFramesDiffer) {
  auto data = standards_dataset("iso9283.csv");
  const auto both = iso9283(data, {});
  for (double& value : data.columns[3].values) value += 1000;  // x, from the tracker's seat
  const auto alone = iso9283(data, {.command = {}, .accuracy = false});
  ASSERT_TRUE(alone);
  EXPECT_TRUE(is_missing(alone->worst_ap_nm));
  EXPECT_TRUE(alone->poses[0].ap_axis_nm.empty());
  EXPECT_NEAR(alone->worst_rp_nm, both->worst_rp_nm, 1e-6);
}

TEST(Iso9283, SaysWhichPoseHasHowManyCycles) {
  auto data = standards_dataset("iso9283.csv");
  data.columns[3].values[7] = kMissing;
  const auto torn = iso9283(data, {});
  ASSERT_FALSE(torn);
  EXPECT_EQ(torn.error().code, ErrorCode::failed_precondition);
  EXPECT_EQ(torn.error().reason, "LACKS_CYCLES");
  EXPECT_THAT(torn.error().message, HasSubstr("(0.2, 1.8, 1.8) mm has 29"));
  const auto fewer = iso9283(data, {.command = {}, .poses = 6, .cycles = 29});
  EXPECT_EQ(fewer.error().reason, "TOO_FEW_POSES");
  const auto asked = iso9283(data, {.command = {}, .cycles = 29});
  ASSERT_TRUE(asked) << asked.error().message;
  EXPECT_THAT(asked->warnings, testing::Contains(HasSubstr("30 cycles")));
}

TEST(Iso9283, CountsNoRowThatIsKeptOut) {
  auto data = standards_dataset("iso9283.csv");
  data.excluded.assign(data.rows, 0);
  data.excluded[7] = 1;
  const auto kept = iso9283(data, {});
  ASSERT_FALSE(kept);
  EXPECT_THAT(kept.error().message, HasSubstr("(0.2, 1.8, 1.8) mm has 29"));
}

TEST(Iso9283, RefusesUnequalColumns) {
  const auto data = standards_dataset("iso9283.csv");
  EXPECT_EQ(iso9283(data, {.command = {"x_target"}, .measured = {"x", "y"}}).error().reason,
            "BAD_COLUMNS");
  EXPECT_EQ(iso9283(data, {.command = {"ry"}, .measured = {"x"}}).error().reason, "UNIT_KIND");
}

// Commands within the tolerance are one pose also across the border of two cells of the search, and
// rotations across the half turn.
TEST(Iso9283, TakesCommandsThatAreAlikeForOnePoseWhereverTheyLie) {
  Dataset data;
  data.columns = {{{"x_target", "mm"}, {}},
                  {{"x", "mm"}, {}},
                  {{"rz_target", "arcsec"}, {}},
                  {{"rz", "arcsec"}, {}}};
  for (int cycle = 0; cycle < 4; ++cycle)
    for (const double x_mm : {0.0, 1.024, -3.072}) {
      const double aside = cycle % 2 == 0 ? 0.4 : -0.4;
      data.columns[0].values.push_back(x_mm + aside * 1e-6);
      data.columns[1].values.push_back(x_mm);
      data.columns[2].values.push_back(aside > 0 ? 647999.9998 : -647999.9998);
      data.columns[3].values.push_back(648000);
      ++data.rows;
    }
  const auto found = iso9283(data, {.poses = 3, .cycles = 4});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->poses.size(), 3U);
}

}  // namespace
}  // namespace driftwise::standards
