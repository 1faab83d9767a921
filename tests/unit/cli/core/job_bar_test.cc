#include "clients/cli/core/job_bar.h"

#include <gtest/gtest.h>

#include <sstream>

namespace driftwise::cli {
namespace {

using std::chrono::seconds;

TEST(JobBar, TellsALogTheWorkOnceAndThenHowFarItIsEveryHalfMinute) {
  std::ostringstream out, err;
  const Console console{out, err, false, false, 80, {}, ".", false, 24, nullptr, false};
  std::chrono::steady_clock::time_point now{};
  JobBar bar(console, [&now] { return now; });
  for (int point = 0; point < 1000; ++point)
    bar.show("turn 1", -1, "measuring 1000 points: " + std::to_string(point) + " of 1000, reading");
  now += seconds(29);
  bar.show("turn 1", -1, "measuring 1000 points: 1000 of 1000, moving");
  now += seconds(1);
  bar.show("turn 1", -1, "measuring 1000 points: 1000 of 1000, done");
  bar.show("turn 1", -1, "");
  bar.show("turn 1", -1, "extending");
  bar.show("turn 2", -1, "extending");
  EXPECT_EQ(err.str(),
            "turn 1: measuring 1000 points: 0 of 1000, reading\n"
            "turn 1: measuring 1000 points: 1000 of 1000, done\n"
            "turn 1: extending\n"
            "turn 2: extending\n");
}

}  // namespace
}  // namespace driftwise::cli
