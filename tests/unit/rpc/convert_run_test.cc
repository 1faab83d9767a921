// A run on the wire: its instants are UTC, its length is not a difference of them.

#include "server/rpc/run/convert_run.h"

#include <gtest/gtest.h>

#include <boost/asio/system_executor.hpp>

#include "server/rpc/shared/wire_time.h"

namespace driftwise::rpc {
namespace {

constexpr CellTime kStart{1'700'000'000'000'000'000};
constexpr std::chrono::hours kHour{1};

// A cell whose computer's clock was set back by an hour, twenty minutes after the start.
class SetBack final : public application::Host {
 public:
  SetBack() { map_times_by(this); }
  ~SetBack() override { stop_mapping_times_by(this); }
  asio::any_io_executor executor() const override { return asio::system_executor(); }
  asio::any_io_executor background() const override { return asio::system_executor(); }
  CellTime now() const override { return kStart + kHour; }
  UtcTime utc(CellTime instant) const override { return map_.utc(instant); }
  CellTime cell_time(UtcTime utc) const override { return map_.cell_time(utc); }

 private:
  UtcMap map_{{{kStart + std::chrono::minutes(20), -kHour}}};
};

RunRecord run_of(Nanoseconds length) {
  RunRecord run;
  run.started = kStart;
  run.ended = kStart + length;
  return run;
}

TEST(RunOnTheWire, LastedAsLongAsItDidAlsoWhenTheClockWasSetBackMeanwhile) {
  const SetBack cell;
  const auto run = run_from(run_of(std::chrono::minutes(30) + std::chrono::milliseconds(250)));
  EXPECT_EQ(run.end_time().seconds() - run.start_time().seconds(), 1800 - 3600)
      << "by the computer's clock it ended before it began";
  EXPECT_EQ(run.elapsed_duration().seconds(), 1800);
  EXPECT_EQ(run.elapsed_duration().nanos(), 250'000'000);
}

TEST(RunOnTheWire, HasNoLengthBeforeItsEnd) {
  auto run = run_of(kHour);
  EXPECT_TRUE(run_from(run).has_elapsed_duration());
  run.ended = {};
  EXPECT_FALSE(run_from(run).has_elapsed_duration()) << "under way";
  run.started = {};
  EXPECT_FALSE(run_from(run).has_elapsed_duration()) << "queued";
  run.ended = kStart;
  EXPECT_FALSE(run_from(run).has_elapsed_duration()) << "aborted before it started";
}

}  // namespace
}  // namespace driftwise::rpc
