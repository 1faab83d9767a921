// Further datums of a fit lie where the robot's zero was then, not only a constant away.

#include "server/calibration/datum_zeros.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <random>

#include "server/formats/formula/formula.h"

namespace driftwise::calibration {
namespace {

using testing::HasSubstr;

// A robot of two motors with curved, coupled geometry and a part that grows, measured in a datum
// each time on 121 poses. zero: where the datum's own zero lies in the robot; homed: by how much
// its scales were homed elsewhere.
struct Measured {
  double x_mm = 0, y_mm = 0, homed_mm = 0, degc = 20;
  int rows = 121;
};

Dataset measure(const std::vector<Measured>& datums, double noise_mm = 1e-5) {
  Dataset data;
  data.columns = {{{"q1", "mm"}, {}},
                  {{"q2", "mm"}, {}},
                  {{"x", "mm"}, {}},
                  {{"y", "mm"}, {}},
                  {{"t01", "degC"}, {}}};
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, noise_mm);
  std::int64_t id = 10;
  for (const auto& datum : datums) {
    for (int i = 0; i < datum.rows; ++i) {
      const double x = -2.5 + 0.5 * (i % 11), y = -2.5 + 0.5 * (i / 11);
      const double warm = datum.degc - 20 + 0.1 * std::sin(0.7 * i);
      const double rx = x + datum.x_mm, ry = y + datum.y_mm;  // in the robot
      data.columns[0].values.push_back(rx + 0.02 * rx * rx + 0.01 * rx * ry + 2e-4 * warm * ry +
                                       3e-4 * warm + datum.homed_mm + noise(random));
      data.columns[1].values.push_back(ry - 0.015 * ry * ry + 0.03 * rx - 1e-4 * warm +
                                       datum.homed_mm + noise(random));
      data.columns[2].values.push_back(x);
      data.columns[3].values.push_back(y);
      data.columns[4].values.push_back(20 + warm);
      data.datum.push_back(id);
      data.time_s.push_back(20.0 * static_cast<double>(data.rows++));
    }
    ++id;
  }
  return data;
}

Model fitted_over_datums(const Dataset& data, const std::string& left = "q", bool move = true) {
  FitOptions options;
  options.move_datums = move;
  auto model = formats::fit_formula(data, left + " ~ poly(x, y, 2) + t01 + t01:(x + y)", options);
  EXPECT_TRUE(model) << model.error().message;
  return std::move(*model);
}

double coefficient_of(const Model& model, std::size_t output, const std::string& name) {
  const auto& one = model.outputs[output];
  for (std::size_t k = 0; k < one.terms.size(); ++k)
    if (effects::notation(one.terms[k]) == name)
      return one.coefficients[static_cast<Eigen::Index>(k)];
  return 0;
}

TEST(DatumZeros, AreFoundWhereTheRobotHadThem) {
  const auto model = fitted_over_datums(
      measure({{}, {.x_mm = 0.01, .y_mm = -0.02, .degc = 23}, {.x_mm = -0.015, .degc = 21}}));
  ASSERT_EQ(model.datum_zeros.size(), 2u);
  ASSERT_EQ(model.datum_zeros[0].pose.size(), 2u) << model.datum_zeros[0].why_not;
  EXPECT_EQ(model.datum_zeros[0].ordinal, 2);
  EXPECT_EQ(model.datum_zeros[0].pose[0].channel, "x_mm");
  // A warmth that is nearly one number per datum leaves the constant to some part unknown.
  EXPECT_NEAR(model.datum_zeros[0].pose[0].value, 0.01, 2e-4);
  EXPECT_NEAR(model.datum_zeros[0].pose[1].value, -0.02, 2e-4);
  EXPECT_NEAR(model.datum_zeros[1].pose[0].value, -0.015, 2e-4);
  for (std::size_t o = 0; o < 2; ++o) EXPECT_NEAR(model.outputs[o].accuracy.rmse, 1e-5, 2e-6);
  EXPECT_NEAR(coefficient_of(model, 0, "datum(2)"), 0, 1e-8);
  EXPECT_THAT(model.warnings,
              testing::Contains(HasSubstr("the zero of datum 2 lies at x_mm = 0.0")));
}

TEST(DatumZeros, ShiftingADatumByAKnownVectorChangesNothingThatIsServed) {
  const Dataset data = measure({{}, {.x_mm = 0.01, .y_mm = -0.02, .degc = 23}});
  const auto before = fitted_over_datums(data);
  Dataset shifted = data;
  for (std::size_t row = 0; row < shifted.rows; ++row)
    if (shifted.datum[row] == 11) {
      shifted.columns[2].values[row] += 0.03;
      shifted.columns[3].values[row] -= 0.025;
    }
  const auto after = fitted_over_datums(shifted);
  for (std::size_t o = 0; o < 2; ++o) {
    ASSERT_EQ(before.outputs[o].terms, after.outputs[o].terms);
    for (Eigen::Index k = 0; k < before.outputs[o].coefficients.size(); ++k)
      EXPECT_NEAR(before.outputs[o].coefficients[k], after.outputs[o].coefficients[k], 1e-8);
  }
  EXPECT_NEAR(after.datum_zeros[0].pose[0].value, before.datum_zeros[0].pose[0].value - 0.03, 1e-8);
  EXPECT_NEAR(after.datum_zeros[0].pose[1].value, before.datum_zeros[0].pose[1].value + 0.025,
              1e-8);
}

TEST(DatumZeros, AFewRowsAreEnough) {
  const auto model = fitted_over_datums(measure({{}, {.x_mm = 0.01, .y_mm = -0.02, .rows = 2}}));
  ASSERT_EQ(model.datum_zeros.size(), 1u);
  ASSERT_FALSE(model.datum_zeros[0].pose.empty()) << model.datum_zeros[0].why_not;
  EXPECT_NEAR(model.datum_zeros[0].pose[1].value, -0.02, 1e-4);
}

TEST(DatumZeros, ScalesHomedElsewhereKeepAConstantAndItIsSaid) {
  const auto near = fitted_over_datums(measure({{}, {.homed_mm = 0.04}}));
  ASSERT_EQ(near.datum_zeros.size(), 1u);
  EXPECT_TRUE(near.datum_zeros[0].pose.empty());
  EXPECT_NEAR(coefficient_of(near, 0, "datum(2)"), 0.04, 1e-4);
  EXPECT_THAT(near.datum_zeros[0].why_not, HasSubstr("fit better where they were measured"));
  EXPECT_THAT(near.warnings, testing::Contains(HasSubstr("datum 2 has a constant of its own")));
  const auto far = fitted_over_datums(measure({{}, {.homed_mm = 0.5}}));
  EXPECT_THAT(far.datum_zeros[0].why_not, HasSubstr("more than 2 % of the range fitted"));
  EXPECT_NEAR(coefficient_of(far, 1, "datum(2)"), 0.5, 1e-4);
}

TEST(DatumZeros, OneBeyondDoesNotHoldTheOthersBack) {
  const auto model = fitted_over_datums(
      measure({{}, {.homed_mm = 0.04}, {.x_mm = 0.01, .y_mm = -0.02, .degc = 22}}));
  ASSERT_EQ(model.datum_zeros.size(), 2u);
  EXPECT_TRUE(model.datum_zeros[0].pose.empty());
  ASSERT_FALSE(model.datum_zeros[1].pose.empty()) << model.datum_zeros[1].why_not;
  EXPECT_NEAR(model.datum_zeros[1].pose[1].value, -0.02, 2e-4);
  EXPECT_NEAR(model.outputs[0].accuracy.rmse, 1e-5, 2e-6);
}

// Twenty of forty datums were homed elsewhere. They are told from the others in a few fits, counted
// by the work that these give to their executor.
TEST(DatumZeros, OfManyDatumsAreJudgedFromFewFits) {
  std::vector<Measured> datums = {{}};
  for (int i = 0; i < 40; ++i)
    datums.push_back(i % 2 == 0 ? Measured{.homed_mm = 0.02 + 0.001 * i, .rows = 12}
                                : Measured{.x_mm = 0.01, .y_mm = -0.001 * i, .rows = 12});
  const Dataset data = measure(datums);
  int asked = 0;
  FitOptions options;
  options.blocks = 0;
  options.candidates =
      *formats::Formula::parse("q ~ poly(x, y, 2) + t01 + t01:(x + y)")->expand(data);
  options.select = Select::all;
  options.executor = [&](std::size_t count, const std::function<void(std::size_t)>& job) {
    ++asked;
    for (std::size_t i = 0; i < count; ++i) job(i);
  };
  const auto zeros = find_datum_zeros(data, options);
  ASSERT_EQ(zeros.size(), 40u);
  int homed_right = 0, moved_right = 0;
  for (std::size_t i = 0; i < zeros.size(); ++i)
    (i % 2 == 0 ? homed_right : moved_right) += zeros[i].pose.empty() == (i % 2 == 0) ? 1 : 0;
  std::printf("executor asked %d times; %d of 20 homed elsewhere, %d of 20 moved\n", asked,
              homed_right, moved_right);
  EXPECT_EQ(homed_right, 20);
  EXPECT_EQ(moved_right, 20);
  EXPECT_LT(asked, 300) << "a fit asks its executor a handful of times";
}

// A datum of one row meets its constant wherever it is moved: nothing to ask about.
TEST(DatumZeros, OfOneRowEachCostAFewFits) {
  std::mt19937 random(1);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> place(-50, 50);
  Dataset data;
  data.columns = {{{"q1", "mm"}, {}}, {{"x", "mm"}, {}}, {{"t04", "degC"}, {}}};
  double homed = 0;
  for (int i = 0; i < 120; ++i) {
    const double x = place(random), t = 20 + gauss(random);
    if (i >= 60) homed = 4e-3 * gauss(random);
    data.time_s.push_back(30.0 * i);
    data.datum.push_back(i < 60 ? 0 : i);
    data.columns[0].values.push_back(x + 2e-4 * (t - 20) + homed + 20e-6 * gauss(random));
    data.columns[1].values.push_back(x);
    data.columns[2].values.push_back(t);
    ++data.rows;
  }
  int asked = 0;
  FitOptions options;
  options.select = Select::all;
  options.candidates = *formats::Formula::parse("q ~ x + t04")->expand(data);
  options.executor = [&](std::size_t count, const std::function<void(std::size_t)>& job) {
    ++asked;
    for (std::size_t i = 0; i < count; ++i) job(i);
  };
  EXPECT_EQ(find_datum_zeros(data, options).size(), 60u);
  EXPECT_LT(asked, 100) << "a fit asks its executor a handful of times";
}

TEST(DatumZeros, CannotBeToldByFewerMotorsThanAxes) {
  const auto model = fitted_over_datums(measure({{}, {.x_mm = 0.01}}), "q1");
  ASSERT_EQ(model.datum_zeros.size(), 1u);
  EXPECT_TRUE(model.datum_zeros[0].pose.empty());
  EXPECT_THAT(model.datum_zeros[0].why_not,
              HasSubstr("motor coordinates fitted: 1, axes in their terms: 2"));
}

TEST(DatumZeros, AreLeftAloneWhereOneDatumIsFitted) {
  const Dataset data = measure({{}});
  EXPECT_TRUE(fitted_over_datums(data).datum_zeros.empty());
  EXPECT_TRUE(find_datum_zeros(data, {}).empty());
}

// Every coordinate of these rows with the robot's id.
Dataset of_robot(Dataset data, const std::string& robot) {
  for (auto& column : data.columns)
    if (column.channel.unit == "mm") column.channel.symbol.insert(0, robot + ".");
  return data;
}

TEST(DatumZeros, OfARobotWithAnIdAreThoseOfTheSameRowsWithoutIt) {
  const Dataset data =
      measure({{}, {.x_mm = 0.01, .y_mm = -0.02, .degc = 23}, {.x_mm = -0.015, .degc = 21}});
  const auto alone = fitted_over_datums(data);
  const auto fitted = formats::fit_formula(
      of_robot(data, "mn"), "mn.q ~ poly(mn.x, mn.y, 2) + t01 + t01:(mn.x + mn.y)", {});
  ASSERT_TRUE(fitted) << fitted.error().message;
  ASSERT_EQ(fitted->datum_zeros.size(), 2u);
  for (std::size_t datum = 0; datum < 2; ++datum) {
    const auto& zero = fitted->datum_zeros[datum];
    ASSERT_EQ(zero.pose.size(), 2u) << zero.why_not;
    EXPECT_EQ(zero.pose[0].channel, "mn.x_mm");
    for (std::size_t axis = 0; axis < 2; ++axis)
      EXPECT_NEAR(zero.pose[axis].value, alone.datum_zeros[datum].pose[axis].value, 1e-9);
  }
  EXPECT_THAT(fitted->warnings,
              testing::Contains(HasSubstr("the zero of datum 2 lies at mn.x_mm = 0.0")));
}

// A length of another robot among the terms is no axis of this one.
TEST(DatumZeros, OfOneRobotAreNotMovedAlongTheOther) {
  Dataset data = of_robot(measure({{}, {.x_mm = 0.01, .y_mm = -0.02, .degc = 23}}), "mn");
  auto& height = data.columns.emplace_back(DatasetColumn{{"ma.z", "mm"}, {}}).values;
  for (std::size_t row = 0; row < data.rows; ++row) {
    height.push_back(std::sin(1.3 * static_cast<double>(row)));
    data.columns[0].values[row] += 1e-3 * height[row];
  }
  const auto fitted =
      formats::fit_formula(data, "mn.q ~ poly(mn.x, mn.y, 2) + t01 + t01:(mn.x + mn.y) + ma.z", {});
  ASSERT_TRUE(fitted) << fitted.error().message;
  ASSERT_EQ(fitted->datum_zeros.size(), 1u);
  const auto& zero = fitted->datum_zeros[0];
  ASSERT_EQ(zero.pose.size(), 2u) << zero.why_not;
  EXPECT_NEAR(zero.pose[0].value, 0.01, 2e-4);
  EXPECT_NEAR(zero.pose[1].value, -0.02, 2e-4);
}

}  // namespace
}  // namespace driftwise::calibration
