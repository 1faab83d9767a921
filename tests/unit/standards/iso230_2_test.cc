#include "server/standards/iso230_2.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "server/core/data/row_marks.h"
#include "tests/unit/standards/standards_data.h"

namespace driftwise::standards {
namespace {

using testing::HasSubstr;

void expect_figure(double found, double by_r, const std::string& name) {
  // Sums of at most 35 terms in doubles, differences of positions of 3 mm known to 4e-10 nm.
  EXPECT_NEAR(found, by_r, 1e-8) << name;
}

TEST(Iso2302, GivesTheFiguresThatRGives) {
  const auto found = iso230_2(standards_dataset("iso230_2.csv"), {});
  ASSERT_TRUE(found) << found.error().message;
  const auto r = figures_by_r("iso230_2");
  expect_figure(found->a.both_nm, r.at("A"), "A");
  expect_figure(found->a.up_nm, r.at("A_up"), "A up");
  expect_figure(found->a.down_nm, r.at("A_down"), "A down");
  expect_figure(found->r.both_nm, r.at("R"), "R");
  expect_figure(found->r.up_nm, r.at("R_up"), "R up");
  expect_figure(found->r.down_nm, r.at("R_down"), "R down");
  expect_figure(found->e.both_nm, r.at("E"), "E");
  expect_figure(found->e.up_nm, r.at("E_up"), "E up");
  expect_figure(found->e.down_nm, r.at("E_down"), "E down");
  expect_figure(found->m_nm, r.at("M"), "M");
  expect_figure(found->b_nm, r.at("B"), "B");
  expect_figure(found->mean_b_nm, r.at("B_mean"), "mean B");
  ASSERT_EQ(found->positions.size(), 7U);
  for (std::size_t i = 0; i < 7; ++i) {
    expect_figure(found->positions[i].r_nm, r.at("R_" + std::to_string(i + 1)), "R_i");
    expect_figure(found->positions[i].reversal_nm, r.at("B_" + std::to_string(i + 1)), "B_i");
  }
  EXPECT_THAT(found->turning_points_mm, testing::ElementsAre(-3.5, 3.5));
  EXPECT_TRUE(found->warnings.empty());
  ASSERT_EQ(found->conditions.temperatures.size(), 1U);
  EXPECT_NEAR(found->conditions.temperatures[0].last_degc, 20.82, 1e-12);
}

// Five passes over five positions with a play of 600 nm. looked_again: at 2 mm on two ways down the
// axis went on, stepped aside and came from below: passages, which have no wanted pose.
Dataset compensated_axis(bool looked_again) {
  Dataset data = visits_of({});
  data.columns.push_back({{"x_target", "mm"}, {}});
  const auto add = [&data](double commanded_mm, double wanted_mm, double deviation_nm) {
    data.columns[0].values.push_back(commanded_mm);
    data.columns[1].values.push_back(wanted_mm + deviation_nm * 1e-6);
    data.columns[2].values.push_back(wanted_mm);
    data.excluded.push_back(is_missing(wanted_mm) ? kPassageRow : kInUse);
    ++data.rows;
  };
  const std::array<double, 5> up = {-4, -2, 0.5, 2, 4}, down = {4, 2, 0.5, -2, -4};
  for (int pass = 0; pass < 5; ++pass)
    for (const bool from_below : {true, false}) {
      const double end_mm = from_below ? -4.5 : 4.5;
      add(end_mm, end_mm, 0);
      for (const double at_mm : from_below ? up : down) {
        double deviation_nm = (from_below ? -300 : 300) + 10 * pass;
        if (looked_again && !from_below && at_mm == 2 && pass % 2 == 1) {
          add(at_mm, kMissing, 0);
          add(at_mm - 0.1, kMissing, 0);
          deviation_nm -= 600;
        }
        add(at_mm, at_mm, deviation_nm);
      }
    }
  return data;
}

TEST(Iso2302, AVisitFromTheOtherSideIsNoneOfTheSideThatWasPlanned) {
  const auto whole = iso230_2(compensated_axis(false), {});
  ASSERT_TRUE(whole) << whole.error().message;
  EXPECT_EQ(whole->columns.target, "x_target");
  const double s_nm = 10 * std::sqrt(2.5);  // of 0, 10, 20, 30, 40
  EXPECT_NEAR(whole->r.both_nm, 600 + 4 * s_nm, 1e-6);
  const auto lacking = iso230_2(compensated_axis(true), {});
  ASSERT_FALSE(lacking) << "R would be " << lacking->r.both_nm << " nm";
  EXPECT_EQ(lacking.error().reason, "LACKS_APPROACHES");
  EXPECT_THAT(lacking.error().message, HasSubstr("2 mm has 7 from below, 3 from above"));
}

TEST(Iso2302, ASecondReadingAtOnePlaceIsNoSecondApproach) {
  auto data = compensated_axis(false);
  for (auto& column : data.columns) {
    const std::vector<double> first(column.values.begin(), column.values.begin() + 2);
    column.values.insert(column.values.begin(), {first[0], first[1], first[1]});
  }
  data.columns[1].values[2] += 5e-3;  // an outlier
  data.excluded.insert(data.excluded.begin(), 3, kInUse);
  data.rows += 3;
  const auto found = iso230_2(data, {});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_LT(found->positions.front().up.r_nm, 100);
}

// An acceptance report that its makers published (tests/data/standards/README.md): readings, and
// their figures as printed, to 1e-8 mm.
struct ReportedPosition {
  double target_mm;
  std::array<double, 5> forward_mm, backward_mm;
  double mean_mm, b_mm, s_forward_mm, s_backward_mm, r_mm;
};
constexpr std::array<ReportedPosition, 5> kReport = {
    {{-10.0,
      {-10.00008102, -10.00010202, -10.00008702, -10.00009202, -10.00010002},
      {-10.00009902, -10.00009402, -10.00008202, -10.00009102, -10.00009402},
      -9.222e-05,
      -4e-07,
      8.79e-06,
      6.28e-06,
      3.517e-05},
     {-4.88,
      {-4.88008702, -4.88009702, -4.88009702, -4.88009502, -4.88008202},
      {-4.88010302, -4.88010402, -4.88009502, -4.88011102, -4.88009302},
      -9.642e-05,
      9.6e-06,
      6.77e-06,
      7.29e-06,
      3.772e-05},
     {0.24,
      {0.23992798, 0.23990998, 0.23991198, 0.23991298, 0.23991298},
      {0.23991398, 0.23989798, 0.23990898, 0.23992398, 0.23990098},
      -8.782e-05,
      6e-06,
      7.26e-06,
      1.043e-05,
      4.17e-05},
     {5.36,
      {5.35989798, 5.35991398, 5.35991398, 5.35990698, 5.35992198},
      {5.35992798, 5.35990798, 5.35990498, 5.35989698, 5.35991898},
      -8.882e-05,
      -4e-07,
      9e-06,
      1.218e-05,
      4.871e-05},
     {10.48,
      {10.47989998, 10.47988798, 10.47987098, 10.47989098, 10.47990298},
      {10.47989598, 10.47987398, 10.47986998, 10.47985898, 10.47989298},
      -1.1552e-4,
      1.22e-05,
      1.258e-05,
      1.573e-05,
      6.882e-05}}};

Dataset reported_run() {
  std::vector<std::pair<double, double>> visits = {{-11, 0}};
  const auto visit = [&](double target_mm, double measured_mm) {
    visits.emplace_back(target_mm, (measured_mm - target_mm) * 1e6);
  };
  for (std::size_t cycle = 0; cycle < 5; ++cycle) {
    for (const auto& p : kReport) visit(p.target_mm, p.forward_mm[cycle]);
    visits.emplace_back(11, 0);
    for (auto p = kReport.rbegin(); p != kReport.rend(); ++p)
      visit(p->target_mm, p->backward_mm[cycle]);
    visits.emplace_back(-11, 0);
  }
  return visits_of(visits);
}

TEST(Iso2302, GivesTheFiguresOfAPublishedReport) {
  const auto found = iso230_2(reported_run(), {});
  ASSERT_TRUE(found) << found.error().message;
  constexpr double kPrinted_nm = 0.011;  // five decimals of 1e-6 mm, and the rounding of doubles
  for (std::size_t i = 0; i < kReport.size(); ++i) {
    const auto& p = found->positions[i];
    EXPECT_NEAR(p.mean_nm, kReport[i].mean_mm * 1e6, kPrinted_nm);
    EXPECT_NEAR(p.reversal_nm, kReport[i].b_mm * 1e6, kPrinted_nm);
    EXPECT_NEAR(p.up.s_nm, kReport[i].s_forward_mm * 1e6, kPrinted_nm);
    EXPECT_NEAR(p.down.s_nm, kReport[i].s_backward_mm * 1e6, kPrinted_nm);
    EXPECT_NEAR(p.r_nm, kReport[i].r_mm * 1e6, kPrinted_nm);
  }
  EXPECT_NEAR(found->b_nm, 12.2, kPrinted_nm);
  EXPECT_NEAR(found->mean_b_nm, 5.4, kPrinted_nm);
  EXPECT_NEAR(found->r.up_nm, 50.33, kPrinted_nm);
  EXPECT_NEAR(found->r.down_nm, 62.90, kPrinted_nm);
  EXPECT_NEAR(found->e.up_nm, 24.6, kPrinted_nm);
  EXPECT_NEAR(found->e.down_nm, 33.0, kPrinted_nm);
  EXPECT_NEAR(found->m_nm, 27.7, kPrinted_nm);
  EXPECT_NEAR(found->a.up_nm, 64.28, kPrinted_nm);
  EXPECT_NEAR(found->a.down_nm, 88.81, kPrinted_nm);
  // Of both sides together, by hand from the report's table: R is its R(5); E spans from -84.82 of
  // the third position forward to -121.62 of the fifth backward.
  EXPECT_NEAR(found->r.both_nm, 68.82, kPrinted_nm);
  EXPECT_NEAR(found->e.both_nm, 36.8, kPrinted_nm);
}

TEST(Iso2302, IsUntouchedByAnOffsetAndByUnits) {
  auto data = standards_dataset("iso230_2.csv");
  const auto before = iso230_2(data, {});
  for (auto& column : data.columns)
    if (column.channel.symbol == "x") {
      for (double& value : column.values) value = (value + 0.5) * 1e6;  // mm -> nm, shifted
      column.channel.unit = "nm";
    }
  const auto after = iso230_2(data, {});
  ASSERT_TRUE(after) << after.error().message;
  EXPECT_NEAR(after->a.both_nm, before->a.both_nm, 1e-6);
  EXPECT_NEAR(after->r.both_nm, before->r.both_nm, 1e-6);
  EXPECT_NEAR(after->b_nm, before->b_nm, 1e-6);
}

TEST(Iso2302, TakesTheFirstFiveApproachesWhereThereAreMore) {
  auto data = standards_dataset("iso230_2.csv");
  const auto before = iso230_2(data, {});
  const std::size_t rows = data.rows;
  for (auto& column : data.columns)  // the whole test once more, worse
    for (std::size_t row = 0; row < rows; ++row)
      column.values.push_back(column.values[row] +
                              (column.channel.symbol == "x" && row % 2 ? 1e-3 : 0));
  for (std::size_t row = 0; row < rows; ++row) {
    data.time_s.push_back(data.time_s[row] + 1e4);
    data.zero.push_back(data.zero[row]);
  }
  data.rows *= 2;
  const auto after = iso230_2(data, {});
  ASSERT_TRUE(after) << after.error().message;
  EXPECT_EQ(after->a.both_nm, before->a.both_nm);
  EXPECT_THAT(after->warnings, testing::ElementsAre(HasSubstr("the first ones in time count")));
}

// The axis still turned round there.
TEST(Iso2302, IsTheSameWithoutTheRowsInWhichTheAxisTurnedRound) {
  auto data = standards_dataset("iso230_2.csv");
  const auto before = iso230_2(data, {});
  for (const double target_mm : data.find("q1_cmd")->values)
    data.excluded.push_back(std::abs(target_mm) > 3.4 ? 1 : 0);
  const auto after = iso230_2(data, {});
  ASSERT_TRUE(after) << after.error().message;
  EXPECT_EQ(after->a.both_nm, before->a.both_nm);
  EXPECT_EQ(after->r.up_nm, before->r.up_nm);
  EXPECT_EQ(after->r.down_nm, before->r.down_nm);
  EXPECT_TRUE(after->turning_points_mm.empty()) << "those rows are in no figure";
}

// Six passes of five positions; +-500 nm of play. Kept out: in the second pass the reading at the
// end going up and the overrun after it, as a stretch of time that somebody keeps out.
TEST(Iso2302, AStretchThatIsKeptOutLeavesTheSidesOfTheOtherReadings) {
  std::vector<std::pair<double, double>> visits = {{-1, 0}};
  for (int pass = 0; pass < 6; ++pass) {
    for (int p = 0; p < 5; ++p) visits.emplace_back(p, 500 + pass);
    visits.emplace_back(5, 0);
    for (int p = 4; p >= 0; --p) visits.emplace_back(p, -500 - pass);
    visits.emplace_back(-1, 0);
  }
  auto data = visits_of(visits);
  data.excluded.assign(data.rows, 0);
  constexpr std::size_t kSecondPass = 1 + 12;
  data.excluded[kSecondPass + 4] = data.excluded[kSecondPass + 5] = 1;
  const auto found = iso230_2(data, {});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_NEAR(found->positions[4].up.mean_nm, 500 + (0 + 2 + 3 + 4 + 5) / 5.0, 1e-6);
  EXPECT_NEAR(found->positions[4].down.mean_nm, -500 - (0 + 1 + 2 + 3 + 4) / 5.0, 1e-6);
  EXPECT_LT(found->r.up_nm, 10);
}

TEST(Iso2302, SaysWhichPositionHasHowManyApproaches) {
  // Every position from below only, as in a plan that always returns to the low end.
  std::vector<std::pair<double, double>> visits;
  for (int pass = 0; pass < 6; ++pass)
    for (int p = -4; p <= 4; ++p) visits.emplace_back(p, 0);
  const auto one_sided = iso230_2(visits_of(visits), {});
  ASSERT_FALSE(one_sided);
  EXPECT_EQ(one_sided.error().code, ErrorCode::failed_precondition);
  EXPECT_EQ(one_sided.error().reason, "LACKS_APPROACHES");
  EXPECT_THAT(one_sided.error().message, HasSubstr("-3 mm has 6 from below, 0 from above"));
  EXPECT_THAT(one_sided.error().message, HasSubstr("driftwise trajectory iso230-2"));

  auto data = standards_dataset("iso230_2.csv");
  for (std::size_t row = 0; row < data.rows; ++row)
    if (data.find("q1_cmd")->values[row] == 1.1 && data.time_s[row] > 12 * 60)
      data.columns[2].values[row] = kMissing;  // x
  const auto torn = iso230_2(data, {});
  ASSERT_FALSE(torn);
  EXPECT_THAT(torn.error().message, HasSubstr("1.1 mm has "));
  EXPECT_THAT(torn.error().message, testing::Not(HasSubstr("0.04 mm")));
}

TEST(Iso2302, NeedsFivePositionsAndFivePerMetre) {
  const auto run = [](int positions, double step_mm) {
    std::vector<std::pair<double, double>> visits = {{-step_mm, 0}};
    for (int cycle = 0; cycle < 5; ++cycle) {
      for (int p = 0; p < positions; ++p) visits.emplace_back(p * step_mm, 0);
      visits.emplace_back(positions * step_mm, 0);
      for (int p = positions - 1; p >= 0; --p) visits.emplace_back(p * step_mm, 0);
      visits.emplace_back(-step_mm, 0);
    }
    return iso230_2(visits_of(visits), {});
  };
  EXPECT_EQ(run(4, 1).error().reason, "TOO_FEW_POSITIONS");
  EXPECT_TRUE(run(5, 1));
  EXPECT_TRUE(run(5, 250));
  const auto sparse = run(6, 300);
  ASSERT_FALSE(sparse);
  EXPECT_THAT(sparse.error().message, HasSubstr("needs 8 positions over 1500 mm, found 6"));
}

TEST(Iso2302, RefusesRowsThatSayNoCommand) {
  Dataset data;
  data.rows = 1;
  data.columns = {{{"q1", "mm"}, {0}}, {{"x", "mm"}, {0}}};
  EXPECT_EQ(iso230_2(data, {}).error().reason, "NO_COLUMN");
  data.columns[0].channel = {"q1_cmd", "V"};
  EXPECT_EQ(iso230_2(data, {}).error().reason, "UNIT_KIND");
}

}  // namespace
}  // namespace driftwise::standards
