// Streams under slow, cancelled and many clients.

#include <new>
#include <stdexcept>

#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/data_service.grpc.pb.h"
#include "driftwise/v1/run_service.grpc.pb.h"
#include "tests/unit/rpc/rpc_fixture.h"

namespace driftwise::tests {
namespace {

class StreamsTest : public RpcTest {
 protected:
  StreamsTest() {
    fakes.runs = &runs;
    fakes.datasets = &datasets;
    fakes.feeds = &feeds;
    runs.add(3);
  }
  app::RunProgress progress(std::int64_t accepted, RunState state = RunState::running) {
    app::RunProgress p;
    p.run.id = {3};
    p.run.rows = 100;
    p.run.accepted = accepted;
    p.run.state = state;
    p.sequence = ++sequence_;
    return p;
  }
  void publish(const app::RunProgress& p) {
    cell.on_executor([&] { runs.progress.publish(p); });
  }
  EventRecord add_event(const std::string& what) {
    EventRecord event;
    event.what = what;
    event.id = cell.add_event(what);
    cell.on_executor([&] { feeds.events.publish(event); });
    return event;
  }
  FakeRuns runs;
  FakeDatasets datasets;
  FakeFeeds feeds;

 private:
  std::int64_t sequence_ = 0;
};

TEST_F(StreamsTest, AWatchEndsWithTheStateInWhichTheRunIsOver) {
  Call call;
  v1::WatchRunRequest request;
  request.set_run_id(3);
  v1::RunService::Stub stub(channel);
  const auto reader = stub.WatchRun(&call, request);
  ASSERT_TRUE(eventually([&] { return runs.progress.now == 1; }));
  publish(progress(1));
  v1::WatchRunResponse response;
  ASSERT_TRUE(reader->Read(&response));
  EXPECT_EQ(response.progress().run().accepted_count(), 1);
  EXPECT_FALSE(response.progress().has_last_spread_nm());
  publish(progress(100, RunState::done));
  ASSERT_TRUE(reader->Read(&response));
  EXPECT_EQ(response.progress().run().state(), v1::Run::STATE_DONE);
  EXPECT_FALSE(reader->Read(&response));
  EXPECT_TRUE(reader->Finish().ok());
  EXPECT_TRUE(eventually([&] { return runs.progress.now == 0; }));
}

// The grace is for calls that will end by themselves; whoever watches is told at once.
TEST_F(StreamsTest, AnOpenWatchDoesNotDelayTheEndOfTheDaemon) {
  Call call;
  v1::WatchRunRequest request;
  request.set_run_id(3);
  v1::RunService::Stub stub(channel);
  const auto reader = stub.WatchRun(&call, request);
  ASSERT_TRUE(eventually([&] { return runs.progress.now == 1; }));
  const auto grace = std::chrono::seconds(60);
  const auto begin = std::chrono::steady_clock::now();
  server->shut_down(grace);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, grace / 2) << "it waited for the stream";
  v1::WatchRunResponse response;
  while (reader->Read(&response)) {
  }
  EXPECT_FALSE(reader->Finish().ok());
}

TEST_F(StreamsTest, AWatchOfARunThatIsOverTellsItsEnd) {
  cell.on_executor([&] { runs.runs[3].state = RunState::failed; });
  Call call;
  v1::WatchRunRequest request;
  request.set_run_id(3);
  v1::RunService::Stub stub(channel);
  const auto reader = stub.WatchRun(&call, request);
  v1::WatchRunResponse response;
  ASSERT_TRUE(reader->Read(&response));
  EXPECT_EQ(response.progress().run().state(), v1::Run::STATE_FAILED);
  EXPECT_FALSE(reader->Read(&response));
  EXPECT_TRUE(reader->Finish().ok());
}

TEST_F(StreamsTest, AWatchOfNothingSaysSo) {
  const auto refused = [&](std::optional<std::int64_t> id) {
    Call call;
    v1::WatchRunRequest request;
    if (id) request.set_run_id(*id);
    v1::RunService::Stub stub(channel);
    const auto reader = stub.WatchRun(&call, request);
    v1::WatchRunResponse response;
    EXPECT_FALSE(reader->Read(&response));
    return rpc::to_error(reader->Finish());
  };
  EXPECT_EQ(refused(99).code, ErrorCode::not_found);
  EXPECT_EQ(refused(-1).reason, "BAD_ID");
  EXPECT_EQ(refused(std::nullopt).reason, "NO_RUN");
}

// A reader that does not read: gRPC's windows fill, then only the latest state waits for it.
TEST_F(StreamsTest, ASlowWatcherMissesStatesButNeverSlowsTheRun) {
  Call call;
  v1::WatchRunRequest request;
  request.set_run_id(3);
  v1::RunService::Stub stub(channel);
  const auto reader = stub.WatchRun(&call, request);
  ASSERT_TRUE(eventually([&] { return runs.progress.now == 1; }));
  constexpr int kStates = 3000;
  auto big = progress(0);
  big.run.reason = std::string(2000, 'r');  // 6 MB in all, far more than the windows hold
  const auto began = std::chrono::steady_clock::now();
  for (int i = 1; i <= kStates; ++i) {
    big.run.accepted = i;
    big.sequence = i + 1;
    publish(big);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(10))
      << "nobody waited for the reader";
  publish(progress(kStates + 1, RunState::done));
  v1::WatchRunResponse response;
  std::int64_t last = -1;
  int count = 0;
  while (reader->Read(&response)) {
    EXPECT_GT(response.progress().run().accepted_count(), last) << "in order, never twice";
    last = response.progress().run().accepted_count();
    ++count;
  }
  EXPECT_TRUE(reader->Finish().ok());
  EXPECT_EQ(last, kStates + 1) << "the end is always told";
  EXPECT_LT(count, kStates) << "and some between were not";
}

TEST_F(StreamsTest, EventsComeAllAndInOrderFromACursor) {
  const std::int64_t first = add_event("run.started").id.value;
  for (int i = 1; i < 250; ++i) add_event("run.started");  // more than a batch
  Call call;
  v1::WatchEventsRequest request;
  request.set_after_event_id(first + 9);
  v1::CellService::Stub stub(channel);
  const auto reader = stub.WatchEvents(&call, request);
  v1::WatchEventsResponse response;
  for (std::int64_t id = first + 10; id < first + 250; ++id) {
    ASSERT_TRUE(reader->Read(&response));
    ASSERT_EQ(response.event().id(), id);
  }
  for (int i = 0; i < 150; ++i) add_event("lease.taken");  // while it watches
  for (std::int64_t id = first + 250; id < first + 400; ++id) {
    ASSERT_TRUE(reader->Read(&response));
    ASSERT_EQ(response.event().id(), id);
  }
}

TEST_F(StreamsTest, EventsWithoutACursorBeginNow) {
  for (int i = 0; i < 5; ++i) add_event("old");
  Call call;
  v1::CellService::Stub stub(channel);
  const auto reader = stub.WatchEvents(&call, v1::WatchEventsRequest{});
  ASSERT_TRUE(eventually([&] { return feeds.events.now == 1; }));
  add_event("new");
  add_event("newer");
  v1::WatchEventsResponse response;
  ASSERT_TRUE(reader->Read(&response));
  EXPECT_EQ(response.event().what(), "new");
  ASSERT_TRUE(reader->Read(&response));
  EXPECT_EQ(response.event().what(), "newer");
}

TEST_F(StreamsTest, AnEventThatIsNotInTheRecordYetIsNotLost) {
  Call call;
  v1::CellService::Stub stub(channel);
  v1::WatchEventsRequest request;
  const std::int64_t newest = add_event("last").id.value;
  request.set_after_event_id(newest);
  const auto reader = stub.WatchEvents(&call, request);
  ASSERT_TRUE(eventually([&] { return feeds.events.now == 1; }));
  EventRecord quick;
  quick.id = {newest + 1};
  quick.what = "quick";
  cell.on_executor([&] { feeds.events.publish(quick); });  // the query does not see it
  v1::WatchEventsResponse response;
  ASSERT_TRUE(reader->Read(&response));
  EXPECT_EQ(response.event().what(), "quick");
}

TEST_F(StreamsTest, ReadingsTellHowManyWereMissed) {
  Call call;
  v1::CellService::Stub stub(channel);
  const auto reader = stub.WatchReadings(&call, v1::WatchReadingsRequest{});
  ASSERT_TRUE(eventually([&] { return feeds.readings.now == 1; }));
  constexpr std::int64_t kReadings = 20'000;
  cell.on_executor([&] {
    Reading reading;
    reading.device = "scanner";
    reading.values = {{std::string(500, 'c') + "_degC", 20.5}};
    for (std::int64_t i = 1; i <= kReadings; ++i) {  // in one go: no write can finish in between
      reading.sequence = i;
      feeds.readings.publish(reading);
    }
  });
  v1::WatchReadingsResponse response;
  std::int64_t seen = 0, missed = 0;
  while (seen + missed < kReadings && reader->Read(&response)) {
    ++seen;
    missed += response.missed_count();
    EXPECT_EQ(response.reading().sequence(), seen + missed);
  }
  EXPECT_EQ(seen + missed, kReadings) << "each one was sent or counted";
  EXPECT_GT(missed, 0);
}

TEST_F(StreamsTest, AnUnknownDeviceIsRefused) {
  Call call;
  v1::WatchReadingsRequest request;
  request.set_device_id("laser-y");
  v1::CellService::Stub stub(channel);
  const auto reader = stub.WatchReadings(&call, request);
  v1::WatchReadingsResponse response;
  EXPECT_FALSE(reader->Read(&response));
  EXPECT_EQ(rpc::to_error(reader->Finish()).reason, "NO_DEVICE");
}

TEST_F(StreamsTest, FortyClientsThatVanishLeaveNothingBehind) {
  for (int round = 0; round < 40; ++round) {
    Call call;
    v1::CellService::Stub stub(channel);
    const auto reader = stub.WatchReadings(&call, v1::WatchReadingsRequest{});
    if (round % 2 == 0) {
      ASSERT_TRUE(eventually([&] { return feeds.readings.now > 0; }));
    }
    call.TryCancel();  // also before the stream began
    reader->Finish();
  }
  EXPECT_TRUE(eventually([&] { return feeds.readings.now == 0; }));
}

TEST_F(StreamsTest, AnExceptionOfItsWorkEndsTheStreamAndNotTheDaemon) {
  const auto exported = [&](std::exception_ptr thrown) {
    cell.on_executor([&] { datasets.throws_next = thrown; });
    Call call;
    v1::ExportDatasetRequest request;
    request.add_run_ids(3);
    const auto reader = v1::DataService::Stub(channel).ExportDataset(&call, request);
    v1::ExportDatasetResponse response;
    while (reader->Read(&response)) {
    }
    return reader->Finish();
  };
  EXPECT_EQ(rpc::to_error(exported(std::make_exception_ptr(std::bad_alloc()))).reason,
            "OUT_OF_MEMORY");
  const auto bug = rpc::to_error(exported(std::make_exception_ptr(std::length_error("too long"))));
  EXPECT_EQ(bug.reason, "BUG");
  EXPECT_THAT(bug.message, testing::HasSubstr("too long"));
  EXPECT_TRUE(exported(nullptr).ok());

  cell.on_executor(
      [&] { runs.throws_next = std::make_exception_ptr(std::runtime_error("no page")); });
  Call call;
  v1::WatchRunRequest request;
  request.set_run_id(3);
  const auto reader = v1::RunService::Stub(channel).WatchRun(&call, request);
  v1::WatchRunResponse response;
  EXPECT_FALSE(reader->Read(&response));
  EXPECT_EQ(rpc::to_error(reader->Finish()).reason, "BUG");
}

TEST_F(StreamsTest, AShutdownEndsOpenStreams) {
  Call call;
  v1::CellService::Stub stub(channel);
  const auto reader = stub.WatchReadings(&call, v1::WatchReadingsRequest{});
  ASSERT_TRUE(eventually([&] { return feeds.readings.now == 1; }));
  server->shut_down(std::chrono::milliseconds(10));
  v1::WatchReadingsResponse response;
  EXPECT_FALSE(reader->Read(&response));
  EXPECT_FALSE(reader->Finish().ok());
  EXPECT_TRUE(eventually([&] { return feeds.readings.now == 0; }));
}

}  // namespace
}  // namespace driftwise::tests
