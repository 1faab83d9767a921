// Which thermometers suffice, on data whose answer is known: two of five sensors matter, and one of
// those has a noisier twin.

#include "server/calibration/sensor_sets.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "server/formats/formula/formula.h"

namespace driftwise::calibration {
namespace {

using testing::ElementsAre;

Dataset warm_axis() {
  std::mt19937 random(21);
  std::normal_distribution<double> normal(0, 1);
  Dataset data;
  data.rows = 600;
  std::vector<DatasetColumn> t;
  for (const char* name : {"t04", "t05", "t06", "t07", "t08"}) t.push_back({{name, "degC"}, {}});
  DatasetColumn q{{"q1", "mm"}, {}}, x{{"x", "mm"}, {}};
  std::vector<double> body(4, 21);
  for (std::size_t i = 0; i < data.rows; ++i) {
    for (auto& one : body) one += 0.01 * normal(random);
    data.time_s.push_back(14.3 * static_cast<double>(i));
    data.set.push_back(i % 3 == 2 ? PointSet::validation : PointSet::calibration);
    x.values.push_back(-4 + 0.5 * static_cast<double>(i % 17));
    t[0].values.push_back(body[0]);
    t[1].values.push_back(body[1]);
    t[2].values.push_back(body[2]);
    t[3].values.push_back(body[3]);
    t[4].values.push_back(body[1] + 0.01 * normal(random));  // t05 again, less well
    q.values.push_back(x.values.back() + 4e-4 * (body[1] - 21) - 3e-4 * (body[3] - 21) +
                       5e-6 * normal(random));
  }
  data.columns = {q, x};
  data.columns.insert(data.columns.end(), t.begin(), t.end());
  return data;
}

FitOptions options_for(const Dataset& data, const std::string& formula) {
  FitOptions options;
  options.candidates = *formats::Formula::parse(formula)->expand(data);
  return options;
}

TEST(SensorSets, FindTheTwoThatMatter) {
  const auto data = warm_axis();
  const auto study = study_sensors(data, options_for(data, "q1 ~ x + T"));
  ASSERT_TRUE(study) << study.error().message;
  EXPECT_EQ(study->sets_tried, 32u);
  ASSERT_EQ(study->best.size(), 6u);
  EXPECT_THAT(study->best[study->recommended].sensors, ElementsAre("t05", "t07"));
  const auto& two = study->best[3];
  EXPECT_NEAR(two.a90_blocks_rms * 1e6, 1.645 * 5, 1);
  EXPECT_NEAR(*two.outputs[0].u90_validation * 1e6, 1.645 * 5, 1);
  EXPECT_GT(study->best[4].a90_blocks_rms, 2 * two.a90_blocks_rms);  // one alone
  EXPECT_GT(study->best[5].a90_blocks_rms, study->best[4].a90_blocks_rms);
}

TEST(SensorSets, AreTheSameOnAnyExecutor) {
  const auto data = warm_axis();
  auto options = options_for(data, "q1 ~ x + t05..t07");
  const auto here = study_sensors(data, options);
  options.executor = [](std::size_t count, const std::function<void(std::size_t)>& job) {
    for (std::size_t i = count; i-- > 0;) job(i);
  };
  const auto backwards = study_sensors(data, options);
  ASSERT_TRUE(here && backwards);
  for (std::size_t i = 0; i < here->best.size(); ++i) {
    EXPECT_EQ(here->best[i].sensors, backwards->best[i].sensors);
    EXPECT_EQ(here->best[i].a90_blocks_rms, backwards->best[i].a90_blocks_rms);
  }
}

TEST(SensorSets, NeedThermometersAndBlocks) {
  const auto data = warm_axis();
  EXPECT_EQ(study_sensors(data, options_for(data, "q1 ~ x")).error().reason, "NO_SENSORS");
  auto options = options_for(data, "q1 ~ x + T");
  options.blocks = 0;
  EXPECT_EQ(study_sensors(data, options).error().reason, "NO_BLOCKS");
}

TEST(SensorSets, SayWhyNoSetCanBeRanked) {
  auto data = warm_axis();
  data.excluded.assign(data.rows, 1);
  for (std::size_t i = 0; i < 36; ++i) data.excluded[i] = 0;  // 24 to learn from: 2.4 to a block
  const auto study = study_sensors(data, options_for(data, "q1 ~ x + T"));
  ASSERT_FALSE(study);
  EXPECT_EQ(study.error().reason, "NO_BLOCKS");
  EXPECT_THAT(study.error().message, testing::HasSubstr("q1 has no such figure"));
  EXPECT_THAT(study.error().message, testing::HasSubstr("fewer than three rows to a block"));
}

TEST(SensorSets, AreNotRankedByOneFigureOfLengthsAndAngles) {
  auto data = warm_axis();
  data.columns.push_back({{"rx", "arcsec"}, data.columns[0].values});
  const auto study = study_sensors(data, options_for(data, "q1 + rx ~ x + T"));
  ASSERT_FALSE(study);
  EXPECT_EQ(study.error().reason, "UNITS_DISAGREE");
  EXPECT_THAT(study.error().message, testing::HasSubstr("mm and arcsec"));
}

}  // namespace
}  // namespace driftwise::calibration
