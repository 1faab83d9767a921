// What `driftwise watch` draws out of the stream's batches.

#include "clients/cli/pages/live_picture.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "clients/cli/core/table.h"
#include "clients/cli/pages/sparkline.h"

namespace driftwise::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(Sparkline, StandsForSmallestToLargest) {
  const std::vector<double> ramp{0, 1, 2, 3, 4, 5, 6, 7};
  EXPECT_EQ(sparkline(ramp, 8), "▁▂▃▄▅▆▇█");
  EXPECT_EQ(sparkline(ramp, 2), "▁█") << "the newest, between their own extremes";
  EXPECT_EQ(sparkline(std::vector<double>{5, 5, 5}, 8), "▁▁▁");
  EXPECT_EQ(sparkline(std::vector<double>{0, NAN, 1}, 8), "▁ █") << "a gap stays a gap";
  EXPECT_EQ(sparkline({}, 8), "");
}

class LivePictureTest : public testing::Test {
 protected:
  void SetUp() override {
    v1::WatchResponse batch;
    auto& layout = *batch.add_events()->mutable_layout();
    layout.set_revision(3);
    for (const auto& [channel, unit] :
         std::vector<std::pair<std::string, std::string>>{{"x_mm", "mm"}, {"t07_degC", "degC"}}) {
      auto& column = *layout.add_columns();
      column.set_channel(channel);
      column.set_unit(unit);
      column.set_stale_after_s(10);
    }
    batch.add_events()->mutable_cell()->set_cell_name("micro-nano");
    batch.mutable_cell_time()->set_seconds(1'700'000'000);
    picture.take(batch);
    see({1.5, 21.25}, {900, 48'000});
  }
  void see(const std::vector<double>& values, const std::vector<std::int64_t>& ages_ms,
           std::int64_t revision = 3) {
    v1::WatchResponse batch;
    auto& update = *batch.add_events()->mutable_values();
    update.set_layout_revision(revision);
    for (const double value : values) update.add_values(value);
    for (const auto age : ages_ms) update.add_age_ms(age);
    picture.take(batch);
  }
  std::string screen(std::size_t width = 100, std::size_t height = 40,
                     const std::string& trouble = {}) const {
    return picture.screen(Paint(false), width, height, trouble);
  }

  LivePicture picture{{}};
};

TEST_F(LivePictureTest, ShowsValuesWithUnitAndAge) {
  EXPECT_THAT(screen(), HasSubstr("micro-nano  ● live"));
  EXPECT_THAT(screen(), testing::ContainsRegex("x +1\\.500000 +mm +900\\.0 ms"));
}

TEST_F(LivePictureTest, AnOldValueIsCalledStale) {
  EXPECT_THAT(screen(), testing::ContainsRegex("t07 +21\\.2500 +degC +48[^\n]*stale"));
}

TEST_F(LivePictureTest, ValuesOfAnotherLayoutAreNotShown) {
  see({7, 8}, {0, 0}, 4);
  EXPECT_THAT(screen(), Not(HasSubstr("7.000000")));
}

TEST_F(LivePictureTest, ALostDaemonIsSaidAboveEverything) {
  EXPECT_THAT(screen(100, 40, "cannot reach the daemon"),
              testing::AllOf(HasSubstr("■ not live since 2023-11-14 22:13:20 UTC"),
                             HasSubstr("cannot reach the daemon"), Not(HasSubstr("● live"))));
}

TEST_F(LivePictureTest, AnAlarmStandsUntilItIsOver) {
  v1::WatchResponse batch;
  auto& alarm = *batch.add_events()->mutable_alarm();
  alarm.set_id(1);
  alarm.set_message("laser-x does not answer");
  picture.take(batch);
  EXPECT_THAT(screen(), HasSubstr("▲ laser-x does not answer"));
  alarm.mutable_cleared_time()->set_seconds(1);
  picture.take(batch);
  EXPECT_THAT(screen(), Not(HasSubstr("laser-x")));
}

// While the record takes nothing none of them has a number.
TEST_F(LivePictureTest, AlarmsThatAreNotOnRecordAreToldApart) {
  const auto heard = [this](std::int64_t id, const char* subject, bool over) {
    v1::WatchResponse batch;
    auto& alarm = *batch.add_events()->mutable_alarm();
    alarm.set_id(id);
    alarm.set_kind("device.lost");
    alarm.set_subject(subject);
    alarm.set_message(std::string(subject) + " does not answer");
    alarm.mutable_since_time()->set_seconds(1);
    if (over) alarm.mutable_cleared_time()->set_seconds(2);
    picture.take(batch);
  };
  heard(0, "laser-x", false);
  heard(0, "laser-y", false);
  EXPECT_THAT(screen(), HasSubstr("▲ laser-x does not answer"));
  EXPECT_THAT(screen(), HasSubstr("▲ laser-y does not answer"));
  heard(7, "laser-x", false);  // on record by now
  heard(7, "laser-x", true);
  EXPECT_THAT(screen(), Not(HasSubstr("laser-x")));
  EXPECT_THAT(screen(), HasSubstr("▲ laser-y does not answer"));
}

TEST_F(LivePictureTest, NeverDrawsBeyondTheWindow) {
  v1::WatchResponse batch;
  batch.add_events()->mutable_cell()->add_attention(std::string(300, 'a') + "ü");
  picture.take(batch);
  for (const std::size_t height : {5u, 6u, 40u}) {
    std::istringstream lines(screen(60, height));
    std::size_t count = 0;
    for (std::string line; std::getline(lines, line); ++count)
      EXPECT_LE(width_of(line), 60u) << line;
    EXPECT_LE(count, height);
  }
}

// A line end behind the last line of a full window scrolls the first one away, which says whether
// it is live.
TEST_F(LivePictureTest, EndsAFullWindowWithoutALineEnd) {
  for (const std::size_t height : {5u, 6u, 40u}) {
    const auto text = screen(60, height);
    EXPECT_FALSE(text.ends_with('\n'));
    EXPECT_LT(static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')), height);
  }
}

TEST_F(LivePictureTest, ShowsOnlyTheChannelsThatWereNamed) {
  picture = LivePicture({"t07", "y"});
  SetUp();
  EXPECT_THAT(picture.channels(), testing::ElementsAre("t07_degC"));
  EXPECT_THAT(picture.unknown(), testing::ElementsAre("y"));
}

}  // namespace
}  // namespace driftwise::cli
