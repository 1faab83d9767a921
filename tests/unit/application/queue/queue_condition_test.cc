// Conditions to start: how they are written, and what meets them.

#include "server/application/queue/queue_condition.h"

#include <gtest/gtest.h>

#include "server/application/queue/follow_up.h"

namespace driftwise::application {
namespace {

const std::vector<Channel> kConditionChannels = {{"t12", "degC"}, {"x", "mm"}};
constexpr CellTime kNoon{1'795'262'400'000'000'000};

struct Written {
  const char* text;
  const char* stored;  // empty: refused
};
class ConditionText : public testing::TestWithParam<Written> {};

TEST_P(ConditionText, IsReadAndWrittenInOneForm) {
  const auto parsed = parse_condition(GetParam().text, kConditionChannels);
  if (std::string(GetParam().stored).empty()) {
    ASSERT_FALSE(parsed) << GetParam().text;
    EXPECT_EQ(parsed.error().reason, "BAD_CONDITION");
    return;
  }
  ASSERT_TRUE(parsed) << parsed.error().message;
  EXPECT_EQ(to_string(*parsed), GetParam().stored);
  EXPECT_EQ(to_string(*parse_condition(to_string(*parsed), kConditionChannels)), GetParam().stored);
}

INSTANTIATE_TEST_SUITE_P(
    Table, ConditionText,
    testing::Values(
        Written{"t12 < 20.5 degC for 30 min", "t12_degC < 20.5 degC for 30 min"},
        Written{"t12_degC > 20 degC", "t12_degC > 20 degC"},
        Written{"t12 > 20 degC for 90 s", "t12_degC > 20 degC for 90 s"},
        Written{"t12 coldest within 0.1 degC", "t12_degC lowest of 24 h within 0.1 degC"},
        Written{"t12 lowest of 12 h within 0 degC", "t12_degC lowest of 12 h within 0 degC"},
        Written{"", ""}, Written{"t12", ""}, Written{"t13 < 20 degC", ""},
        Written{"t12 = 20 degC", ""}, Written{"t12 < warm degC", ""}, Written{"t12 < nan degC", ""},
        Written{"t12 < 20 K", ""}, Written{"t12 < 20 degC for 30", ""},
        Written{"t12 < 20 degC for -3 min", ""}, Written{"t12 < 20 degC for 800 h", ""},
        Written{"t12 coldest", ""}, Written{"t12 coldest within -1 degC", ""}));

// Buckets of ten minutes up to noon.
ConditionRecord record_of(double newest, const std::vector<double>& values) {
  ConditionRecord record;
  record.newest = newest;
  record.series.bucket = std::chrono::minutes(10);
  record.series.from = kNoon - record.series.bucket * static_cast<std::int64_t>(values.size());
  record.series.to = kNoon;
  SeriesColumn column;
  for (const double value : values) {
    column.min.push_back(value);
    column.max.push_back(value);
    column.count.push_back(is_missing(value) ? 0 : 10);
  }
  record.series.columns = {column};
  return record;
}

ConditionVerdict judged(const char* text, const ConditionRecord& record) {
  return judge(*parse_condition(text, kConditionChannels), record, kNoon);
}

TEST(Condition, IsMetByTheNewestValueAlone) {
  EXPECT_TRUE(judged("t12 < 20.5 degC", record_of(20.4, {})).met);
  const auto warm = judged("t12 < 20.5 degC", record_of(21.3, {}));
  EXPECT_FALSE(warm.met);
  EXPECT_EQ(warm.sentence, "t12_degC below 20.5 degC: 21.3 now");
}

TEST(Condition, IsMetWhenEveryValueOfTheTimeIs) {
  EXPECT_TRUE(judged("t12 < 20.5 degC for 30 min", record_of(20.3, {20.4, 20.3, 20.3})).met);
  const auto since = judged("t12 < 20.5 degC for 30 min", record_of(20.3, {20.6, 20.4, 20.3}));
  EXPECT_FALSE(since.met);
  EXPECT_EQ(since.sentence, "t12_degC below 20.5 degC for 30 min: 20.3 now, for 20 min");
}

TEST(Condition, IsNotMetAcrossAGapOfTheRecord) {
  const auto gap = judged("t12 < 20.5 degC for 30 min", record_of(20.3, {20.4, kMissing, 20.3}));
  EXPECT_FALSE(gap.met);
  EXPECT_EQ(gap.sentence,
            "t12_degC below 20.5 degC for 30 min: 20.3 now, the record of that time has a gap");
  EXPECT_TRUE(judged("t12 < 20.5 degC for 30 min", record_of(20.3, {20.4, 20.3, kMissing})).met)
      << "the newest bucket may be on its way to the disk";
}

// Ten minutes a bucket: readings that may be twenty minutes apart leave one empty.
TEST(Condition, IsMetByAChannelThatIsReadSeldom) {
  auto seldom = record_of(20.3, {20.4, kMissing, 20.3, kMissing, 20.4, 20.3});
  seldom.most_age_s = 1200;
  EXPECT_TRUE(judged("t12 < 20.5 degC for 60 min", seldom).met);
  seldom = record_of(20.3, {20.4, kMissing, kMissing, kMissing, 20.4, 20.3});
  seldom.most_age_s = 1200;
  EXPECT_FALSE(judged("t12 < 20.5 degC for 60 min", seldom).met);
}

TEST(Condition, IsNotMetByAnOldOrAMissingValue) {
  auto old = record_of(20.3, {20.3, 20.3, 20.3});
  old.age_s = 300;
  EXPECT_EQ(judged("t12 < 20.5 degC", old).sentence,
            "t12_degC below 20.5 degC: no value for 5 min");
  EXPECT_EQ(judged("t12 < 20.5 degC", {}).sentence, "t12_degC below 20.5 degC: it was never read");
}

TEST(Condition, ColdestIsWithinTheToleranceOfTheDaysLowest) {
  std::vector<double> day(96, 21.0);
  day[40] = 19.8;
  const auto warm = judged("t12 coldest within 0.1 degC", record_of(20.2, day));
  EXPECT_FALSE(warm.met);
  EXPECT_EQ(warm.sentence, "t12_degC within 0.1 degC of its lowest of 24 h: 20.2 now, lowest 19.8");
  EXPECT_TRUE(judged("t12 coldest within 0.1 degC", record_of(19.9, day)).met);
  std::fill(day.begin(), day.begin() + 48, kMissing);
  EXPECT_EQ(judged("t12 coldest within 0.1 degC", record_of(19.0, day)).sentence,
            "t12_degC within 0.1 degC of its lowest of 24 h: 50 % of that time is recorded");
}

TEST(FollowUps, AreReadOrRefused) {
  EXPECT_EQ(parse_follow_up("fit:q ~ x + x^2")->formula, "q ~ x + x^2");
  EXPECT_EQ(parse_follow_up("diagnose")->kind, FollowUp::Kind::diagnose);
  EXPECT_EQ(parse_follow_up("notify")->kind, FollowUp::Kind::notify);
  for (const char* bad :
       {"", "fit", "fit:", "diagnose:", "notify:ada", "report:x", "dance", "fit:q ~ x\ny"})
    EXPECT_EQ(parse_follow_up(bad).error().reason, "BAD_FOLLOW_UP") << bad;
  EXPECT_FALSE(parse_follow_up("fit:q ~ ("));
}

}  // namespace
}  // namespace driftwise::application
