// Whoever watches over the wire: one that does not read never slows the run and misses no record;
// one that slept through a daemon's death finds everything after its cursor; a diagnosis that
// somebody else starts is seen while it happens.

#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include <set>

#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/watch_service.grpc.pb.h"
#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

// What a client has seen, by id; a second time is an error.
struct Record {
  std::vector<std::int64_t> events, points;
  std::set<std::int64_t> diagnoses_over;
  std::int64_t values = 0;
  std::string cursor;

  void take(const v1::WatchResponse& batch) {
    cursor = batch.cursor();
    for (const auto& event : batch.events()) {
      if (event.has_record()) events.push_back(event.record().id());
      if (event.has_point()) points.push_back(event.point().id());
      if (event.has_values()) ++values;
      if (event.has_diagnosis() && event.diagnosis().state() != v1::Diagnosis::STATE_RUNNING)
        diagnoses_over.insert(event.diagnosis().diagnosis_id());
    }
  }
};

// A connection of its own, whose buffers hold next to nothing.
std::shared_ptr<grpc::Channel> narrow_channel(const CellAtWork& cell) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  arguments.SetInt(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, 4096);
  return grpc::CreateCustomChannel(cell.grpc_address(), grpc::InsecureChannelCredentials(),
                                   arguments);
}

class Watcher {
 public:
  Watcher(std::shared_ptr<grpc::Channel> channel, const std::string& cursor,
          std::vector<v1::Topic> topics = {})
      : channel_(std::move(channel)) {
    call_.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(120));
    v1::WatchRequest request;
    request.set_cursor(cursor);
    request.set_max_hz(20);
    for (const auto topic : topics) request.add_topics(topic);
    reader_ = v1::WatchService::NewStub(channel_)->Watch(&call_, request);
  }
  ~Watcher() { call_.TryCancel(); }

  // Until it holds of what was seen. False: the stream ended before.
  bool read_until(const std::function<bool()>& holds) {
    v1::WatchResponse batch;
    while (!holds()) {
      if (!reader_->Read(&batch)) return false;
      seen.take(batch);
      last = batch;
    }
    return true;
  }

  Record seen;
  v1::WatchResponse last;

 private:
  std::shared_ptr<grpc::Channel> channel_;
  grpc::ClientContext call_;
  std::unique_ptr<grpc::ClientReader<v1::WatchResponse>> reader_;
};

std::vector<std::int64_t> ids_after(const CellAtWork& cell, const std::string& table,
                                    const std::string& column, std::int64_t after) {
  std::vector<std::int64_t> ids;
  const std::string from = " FROM " + table + " WHERE " + column + " > ";
  for (std::int64_t id = after;;) {
    id = cell.count("SELECT coalesce(min(" + column + "), -1)" + from + std::to_string(id));
    if (id < 0) return ids;
    ids.push_back(id);
  }
}

TEST(Watch, AClientThatDoesNotReadNeverSlowsTheRunAndMissesNoRecord) {
  CellAtWork cell;
  cell.start_daemon();
  Watcher slow(narrow_channel(cell), "");
  ASSERT_TRUE(slow.read_until([&] { return !slow.seen.cursor.empty(); }));
  const auto events_before = cell.count("SELECT coalesce(max(event_id), 0) FROM event");
  const auto run = cell.start_run(campaign(6, 8));
  const auto ended = cell.end_of(run);  // not a byte was read meanwhile
  EXPECT_EQ(ended.at("state"), "done") << ended;
  EXPECT_EQ(ended.at("accepted_count"), 48);
  EXPECT_EQ(ended.at("given_up_count"), 0);
  EXPECT_EQ(cell.count("SELECT count(*) FROM event WHERE what = 'daemon.trouble'"), 0);

  ASSERT_TRUE(slow.read_until([&] { return slow.seen.points.size() == 48; }));
  EXPECT_EQ(slow.seen.points, ids_after(cell, "point", "point_id", 0)) << "each once, in order";
  const auto last = cell.count("SELECT coalesce(max(event_id), 0) FROM event");
  ASSERT_TRUE(slow.read_until(
      [&] { return !slow.seen.events.empty() && slow.seen.events.back() >= last; }));
  const auto all = ids_after(cell, "event", "event_id", 0);
  for (const auto id : all)
    if (id > events_before && id <= last) {
      EXPECT_EQ(std::count(slow.seen.events.begin(), slow.seen.events.end(), id), 1) << id;
    }
  // Of states it was given the latest: far fewer than there were.
  EXPECT_LT(slow.seen.values, cell.count("SELECT count(*) FROM reading") / 2);
}

TEST(Watch, AClientOfReadingsThatDoesNotReadIsToldHowManyItMissed) {
  CellAtWork cell;
  cell.start_daemon();
  const auto channel = narrow_channel(cell);
  grpc::ClientContext call;
  call.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(120));
  const auto reader =
      v1::CellService::NewStub(channel)->WatchReadings(&call, v1::WatchReadingsRequest{});
  v1::WatchReadingsResponse response;
  ASSERT_TRUE(reader->Read(&response));
  const auto run = cell.start_run(campaign(16, 8));
  const auto ended = cell.end_of(run);
  EXPECT_EQ(ended.at("state"), "done") << ended;
  // What the network holds by itself comes first; the gap after it has its number.
  std::int64_t missed = 0;
  for (int i = 0; i < 5000 && missed == 0 && reader->Read(&response); ++i)
    missed = response.missed_count();
  EXPECT_GT(missed, 0);
  call.TryCancel();
}

TEST(Watch, AClientThatSleptThroughTheDaemonsDeathMissesNothing) {
  CellAtWork cell;
  cell.start_daemon();
  const auto run = cell.start_run(campaign(6, 8));
  Record seen;
  {
    Watcher first(cell.channel(), "");
    ASSERT_TRUE(first.read_until([&] { return first.seen.points.size() >= 5; }));
    seen = first.seen;
  }
  const auto point_seen = seen.points.back(), event_seen = seen.events.back();
  cell.wait_for_points(12);
  cell.kill_daemon();
  cell.start_daemon();
  ASSERT_EQ(cell.end_of(run).at("state"), "done");
  Watcher back(cell.channel(), seen.cursor);
  ASSERT_TRUE(back.read_until([&] { return seen.points.size() + back.seen.points.size() >= 48; }));
  const auto missed = ids_after(cell, "point", "point_id", point_seen);
  EXPECT_EQ(back.seen.points, missed) << "each once, in order, from where it left";
  const auto last =
      cell.count("SELECT coalesce(max(event_id), 0) FROM event WHERE what = 'run.done'");
  ASSERT_TRUE(back.read_until(
      [&] { return !back.seen.events.empty() && back.seen.events.back() >= last; }));
  auto events = ids_after(cell, "event", "event_id", event_seen);
  events.resize(std::min(events.size(), back.seen.events.size()));
  EXPECT_EQ(back.seen.events, events);
}

TEST(Watch, ACursorOfAnotherDatabaseIsRefusedAndNotMisread) {
  CellAtWork one, other;
  one.start_daemon();
  other.start_daemon();
  Watcher there(one.channel(), "");
  ASSERT_TRUE(there.read_until([&] { return !there.seen.cursor.empty(); }));
  Watcher here(other.channel(), there.seen.cursor);
  EXPECT_FALSE(here.read_until([] { return false; }));
}

TEST(Watch, ADiagnosisThatSomebodyElseStartsIsSeenAndItsEndIsReplayed) {
  CellAtWork cell;
  cell.start_daemon();
  ASSERT_EQ(cell.end_of(cell.start_run(campaign(8, 6))).at("state"), "done");
  Watcher open(cell.channel(), "", {v1::TOPIC_DIAGNOSES});
  ASSERT_TRUE(open.read_until([&] { return !open.seen.cursor.empty(); }));
  const std::string before = open.seen.cursor;
  const auto said = cell.cli({"diagnose", "--run", "1", "--baseline", "q ~ x + T", "--json"});
  ASSERT_TRUE(said.code == 0 || said.code == 1) << said.err;
  ASSERT_TRUE(open.read_until([&] { return open.seen.diagnoses_over.contains(1); }));
  // One that slept meanwhile.
  Watcher slept(cell.channel(), before, {v1::TOPIC_DIAGNOSES});
  ASSERT_TRUE(slept.read_until([&] { return slept.seen.diagnoses_over.contains(1); }));
  // And one whose daemon was killed under the diagnosis, if it was quick enough.
  cell.kill_daemon();
  cell.start_daemon();
  Watcher after(cell.channel(), before, {v1::TOPIC_DIAGNOSES});
  ASSERT_TRUE(after.read_until([&] { return after.seen.diagnoses_over.contains(1); }));
}

}  // namespace
}  // namespace driftwise::tests
