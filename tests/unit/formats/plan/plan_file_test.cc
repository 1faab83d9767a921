// plan.toml: the study's plan, and one mistake each.

#include "server/formats/plan/plan_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/calibration/fit.h"
#include "server/core/text/shown_text.h"
#include "server/effects/term_order.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/formula/formula.h"
#include "server/formats/model/model_json.h"

namespace driftwise::formats {
namespace {

using compensation::Variable;
using testing::HasSubstr;

constexpr const char* kJointText = R"(name = "joint"

[[robot]]
id = "mn"
model = 12

[[robot]]
id = "ma"

[[blend]]
robot = "ma"
fine = 11
coarse = 10
[[blend.band]]
coordinates = ["rx_arcsec", "ry_arcsec"]
from = 300
to = 350

[[parasitic]]
model = 13
from = "ma"
to = "mn"
add = ["x_mm", "y_mm"]

[[parasitic]]
model = 14
from = "mn"
to = "ma"
add = ["rx_arcsec", "ry_arcsec"]

[z]
taken_by = "mn"
)";

TEST(PlanFile, ReadsTheStudysPlan) {
  const auto plan = read_plan_file(kJointText, "plan.toml");
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_EQ(plan->name, "joint");
  EXPECT_EQ(plan->models(), (std::vector<ModelId>{{10}, {11}, {12}, {13}, {14}}));
  ASSERT_TRUE(plan->robots[1].blend);
  EXPECT_EQ(plan->robots[1].model, (ModelId{11}));
  EXPECT_EQ(plan->robots[1].blend->band.size(), 2u);
  EXPECT_EQ(plan->steps[0].add, (std::vector<Variable>{Variable::x, Variable::y}));
  EXPECT_EQ(plan->z_taken_by, "mn");
  EXPECT_THAT(plans::steps_of(*plan)[1],
              HasSubstr("model 13 predicts parasitic motion of ma; it adds ma.x_mm to mn.x_mm"));
}

TEST(PlanFile, ReadsABandAboutACentreAndOnOneSide) {
  std::string text = kJointText;
  const std::string edge = "from = 300\nto = 350\n";
  text.replace(text.find(edge), edge.size(),
               edge +
                   "[[blend.band]]\ncoordinates = [\"z_mm\"]\nfrom = 1.4\nto = 1.5\ncentre = 1.5\n"
                   "[[blend.band]]\ncoordinates = [\"x_mm\"]\nfrom = 2\nto = 3\n"
                   "side = \"above\"\n");
  const auto plan = read_plan_file(text, "plan.toml");
  ASSERT_TRUE(plan) << plan.error().message;
  const auto& band = plan->robots[1].blend->band;
  ASSERT_EQ(band.size(), 4u);
  EXPECT_EQ(band[0].centre, 0);
  EXPECT_EQ(band[0].side, plans::BandSide::both);
  EXPECT_EQ(band[2].centre, 1.5);
  EXPECT_EQ(band[3].side, plans::BandSide::above);
  std::string all;
  for (const auto& step : plans::steps_of(*plan)) all += step;
  EXPECT_THAT(all, HasSubstr("ma.z_mm from 1.4 to 1.5 mm away from 1.5"));
  EXPECT_THAT(all, HasSubstr("ma.x_mm from 2 to 3 mm above 0"));
}

struct TextMistake {
  const char *name, *from, *to, *reason, *sentence;
};
class PlanText : public testing::TestWithParam<TextMistake> {};
TEST_P(PlanText, IsRefusedWithFileLineAndSentence) {
  std::string text = kJointText;
  const auto at = text.find(GetParam().from);
  ASSERT_NE(at, std::string::npos);
  text.replace(at, std::string(GetParam().from).size(), GetParam().to);
  const auto plan = read_plan_file(text, "plan.toml");
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().reason, GetParam().reason) << plan.error().message;
  EXPECT_THAT(plan.error().message, HasSubstr("plan.toml:"));
  EXPECT_THAT(plan.error().message, HasSubstr(GetParam().sentence));
}
INSTANTIATE_TEST_SUITE_P(
    Mistakes, PlanText,
    testing::Values(
        TextMistake{"Syntax", "[[robot]]", "[[robot", "TOML_SYNTAX", "column"},
        TextMistake{"Key", "coarse = 10", "corse = 10", "MISSING_KEY", "coarse"},
        TextMistake{"UnknownKey", "model = 12", "model = 12\nmodle = 3", "UNKNOWN_KEY", "modle"},
        TextMistake{"BandThatNarrows", "to = 350", "to = 250", "BAD_PLAN",
                    "expected from below to"},
        TextMistake{"BandSide", "to = 350", "to = 350\nside = \"left\"", "OUT_OF_RANGE", "left"},
        TextMistake{"Robot", "robot = \"ma\"", "robot = \"mx\"", "BAD_PLAN", "'mx'"},
        TextMistake{"Itself", "to = \"mn\"", "to = \"ma\"", "BAD_PLAN", "found the robot itself"},
        TextMistake{"Coordinate", "add = [\"x_mm\"", "add = [\"x_nm\"", "BAD_CHANNEL", "'x_nm'"},
        TextMistake{"TwoModels", "id = \"ma\"", "id = \"ma\"\nmodel = 3", "BAD_PLAN",
                    "has a model already"},
        TextMistake{"NoModel", "model = 12", "", "BAD_PLAN", "robot 'mn' has no model"},
        TextMistake{"SameId", "id = \"ma\"", "id = \"mn\"", "DUPLICATE_ID", "two robots 'mn'"},
        TextMistake{"Anchor", "coarse = 10", "coarse = 10\nanchored = true", "MISSING_KEY",
                    "fade_to"},
        TextMistake{"NobodyForZ", "taken_by = \"mn\"", "taken_by = \"x\"", "BAD_PLAN", "'x'"}),
    [](const auto& row) { return std::string(row.param.name); });

// Names with a robot's id on their whole way: table, formula, fit, model as JSON.
TEST(RobotNames, GoFromTheTableToTheModel) {
  std::string csv = "ma.q1_mm,ma.q2_mm,ma.rx_arcsec,ma.z_mm,mn.x_mm,t09_degC\n";
  for (int i = 0; i < 40; ++i) {
    const double rx = 10.0 * (i % 7) - 30, z = 0.5 * (i % 5) - 1;
    for (const double value : {z + 3e-4 * rx, z - 2e-4 * rx, rx, z, 1e-3 * z + 1e-4 * i})
      csv += number_text(value) + ",";
    csv += "20." + std::to_string(10 + i) + "\n";
  }
  const auto data = read_dataset_csv(csv, "joint.csv");
  ASSERT_TRUE(data) << data.error().message;
  EXPECT_EQ(data->columns[2].channel, (Channel{"ma.rx", "arcsec"}));
  const auto formula = Formula::parse("ma.q ~ poly(ma.rx, ma.z, 1)");
  ASSERT_TRUE(formula) << formula.error().message;
  const auto candidates = formula->expand(*data);
  ASSERT_TRUE(candidates) << candidates.error().message;
  EXPECT_EQ(candidates->outputs, (std::vector<std::string>{"ma.q1", "ma.q2"}));
  EXPECT_EQ(candidates->formula, "ma.q ~ poly(ma.rx, ma.z, 1)");
  calibration::FitOptions options;
  options.candidates = *candidates;
  const auto model = calibration::fit(*data, options);
  ASSERT_TRUE(model) << model.error().message;
  const auto back = read_model_json(write_model_json(*model));
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->outputs[1].channel.name(), "ma.q2_mm");
  ASSERT_EQ(back->outputs[0].terms.size(), 3u);
  EXPECT_EQ(effects::notation(back->outputs[0].terms[1]), "ma.rx");
  EXPECT_NEAR(back->outputs[0].coefficients[1], 3e-4, 1e-12);
}

TEST(RobotNames, DoNotTakeTheRangeOfTemperaturesForARobot) {
  const auto formula = Formula::parse("q1 ~ x + t05..t10");
  ASSERT_TRUE(formula) << formula.error().message;
  EXPECT_FALSE(Formula::parse("q1 ~ ma."));
}

}  // namespace
}  // namespace driftwise::formats
