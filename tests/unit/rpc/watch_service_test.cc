// Watch as its clients meet it: states, records by cursor, slow and returning clients.

#include <stdexcept>

#include "driftwise/v1/watch_service.grpc.pb.h"
#include "tests/unit/rpc/rpc_fixture.h"

namespace driftwise::tests {
namespace {

using WatchStub = v1::WatchService::Stub;
using namespace std::string_literals;

class WatchServiceTest : public RpcTest {
 protected:
  WatchServiceTest() {
    fakes.feeds = &feeds;
    run = cell.add_run();
  }
  FakeFeeds feeds;
  RunId run;
  // The number of the event.
  std::int64_t add_event(const std::string& what) {
    const EventId id = cell.add_event(what);
    cell.on_executor([&] { feeds.records.publish(); });
    return id.value;
  }
  struct Seen {
    std::vector<std::int64_t> events, points;
    std::vector<std::string> kinds;  // of everything, in order
    std::string cursor;
  };

  // Reads batches until there is an event of this number.
  Seen watch_until_event(std::int64_t last, const std::string& cursor,
                         std::vector<v1::Topic> topics = {}) {
    Call call;
    v1::WatchRequest request;
    request.set_cursor(cursor);
    request.set_max_hz(20);
    for (const auto topic : topics) request.add_topics(topic);
    WatchStub stub(channel);
    const auto reader = stub.Watch(&call, request);
    Seen seen;
    v1::WatchResponse batch;
    while ((seen.events.empty() || seen.events.back() < last) && reader->Read(&batch)) {
      seen.cursor = batch.cursor();
      for (const auto& event : batch.events()) {
        seen.kinds.push_back(event.GetDescriptor()->FindFieldByNumber(event.event_case())->name());
        if (event.has_record()) seen.events.push_back(event.record().id());
        if (event.has_point()) seen.points.push_back(event.point().id());
      }
    }
    call.TryCancel();
    reader->Finish();
    return seen;
  }

  std::string cursor_now() {
    Call call;
    v1::WatchRequest request;
    WatchStub stub(channel);
    const auto reader = stub.Watch(&call, request);
    v1::WatchResponse batch;
    EXPECT_TRUE(reader->Read(&batch));
    call.TryCancel();
    return batch.cursor();
  }

  void add_points(int count) { cell.add_points(run, count); }
};

std::vector<std::int64_t> numbers(std::int64_t from, std::int64_t to) {
  std::vector<std::int64_t> out;
  for (; from <= to; ++from) out.push_back(from);
  return out;
}

TEST_F(WatchServiceTest, BeginsWithTheLayoutTheValuesAndTheCell) {
  Call call;
  WatchStub stub(channel);
  const auto reader = stub.Watch(&call, v1::WatchRequest{});
  v1::WatchResponse batch;
  ASSERT_TRUE(reader->Read(&batch));
  ASSERT_GE(batch.events_size(), 3);
  const auto& columns = batch.events(0).layout().columns();
  const auto t01 = std::ranges::find(columns, "t01_degC", &v1::ChannelLayout::Column::channel);
  ASSERT_NE(t01, columns.end());
  EXPECT_EQ(t01->unit(), "degC");
  EXPECT_EQ(batch.events(1).values().layout_revision(), batch.events(0).layout().revision());
  const auto at = static_cast<int>(t01 - columns.begin());
  EXPECT_NEAR(batch.events(1).values().values(at), 20.1, 0.05);
  EXPECT_GE(batch.events(1).values().age_ms(at), 0);
  EXPECT_EQ(batch.events(2).cell().cell_name(), "small");
  EXPECT_TRUE(batch.events(2).cell().values().empty());
  EXPECT_TRUE(batch.has_server_time());
  call.TryCancel();
}

TEST_F(WatchServiceTest, ALookThatEndsWithAnExceptionIsRepeated) {
  cell.on_executor(
      [&] { feeds.throws_next = std::make_exception_ptr(std::runtime_error("no page")); });
  const std::string cursor = cursor_now();
  const auto event = add_event("note");
  EXPECT_EQ(watch_until_event(event, cursor).events.back(), event);
}

TEST_F(WatchServiceTest, AHeartbeatComesEverySecondWhateverHappens) {
  Call call;
  v1::WatchRequest request;
  request.add_topics(v1::TOPIC_ALARMS);
  WatchStub stub(channel);
  const auto begin = std::chrono::steady_clock::now();
  const auto reader = stub.Watch(&call, request);
  v1::WatchResponse batch;
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(reader->Read(&batch));
  EXPECT_TRUE(batch.events().empty());
  EXPECT_FALSE(batch.cursor().empty());
  const auto took = std::chrono::steady_clock::now() - begin;
  EXPECT_GT(took, std::chrono::milliseconds(1500));
  EXPECT_LT(took, std::chrono::seconds(10));
  call.TryCancel();
}

TEST_F(WatchServiceTest, AReturningClientGetsEveryRecordOnceWhereItLeft) {
  const std::int64_t first = add_event("before");
  std::string cursor = cursor_now();
  std::vector<std::int64_t> events, points;
  for (int visit = 0; visit < 4; ++visit) {
    const int count = visit == 2 ? 1700 : 20;  // more than a page
    add_points(count);
    std::int64_t last = 0;
    for (int i = 0; i < count; ++i) last = add_event("while away");
    const auto seen = watch_until_event(last, cursor);
    events.insert(events.end(), seen.events.begin(), seen.events.end());
    points.insert(points.end(), seen.points.begin(), seen.points.end());
    cursor = seen.cursor;
  }
  EXPECT_EQ(events, numbers(first + 1, first + 3 * 20 + 1700));
  EXPECT_EQ(points, numbers(1, 3 * 20 + 1700));
}

TEST_F(WatchServiceTest, AStreamThatStaysGetsEveryRecordOnceAsItHappens) {
  const std::int64_t first = add_event("before");
  const std::string cursor = cursor_now();
  std::thread happening([&] {
    for (int i = 0; i < 300; ++i) {
      add_event("now");
      if (i % 10 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  });
  EXPECT_EQ(watch_until_event(first + 300, cursor).events, numbers(first + 1, first + 300));
  happening.join();
}

TEST_F(WatchServiceTest, TopicsLeaveOutTheRestAndTheCursorGoesOn) {
  const std::string cursor = cursor_now();
  add_points(3);
  const auto seen = watch_until_event(add_event("one"), cursor, {v1::TOPIC_EVENTS});
  EXPECT_EQ(seen.kinds, (std::vector<std::string>{"record"}));
  EXPECT_TRUE(watch_until_event(add_event("two"), seen.cursor)
                  .points.empty());  // they were before this cursor
}

TEST_F(WatchServiceTest, RefusesACursorOfAnotherDatabaseOrOfTheFuture) {
  const std::string now = cursor_now(), database = now.substr(0, now.find('.'));
  for (const std::string& cursor :
       {"bb22.0.0.0.0.0.0.0"s, database + ".99.0.0.0.0.0.0", "nonsense"s, database + ".1.2.3",
        database + ".0.0.0.0.0.0" /* of a version before this one */,
        database + ".-1.0.0.0.0.0.0"}) {
    Call call;
    v1::WatchRequest request;
    request.set_cursor(cursor);
    WatchStub stub(channel);
    const auto reader = stub.Watch(&call, request);
    v1::WatchResponse batch;
    EXPECT_FALSE(reader->Read(&batch));
    const auto error = rpc::to_error(reader->Finish());
    EXPECT_EQ(error.code, ErrorCode::out_of_range) << cursor;
    EXPECT_EQ(error.reason, "CURSOR_TOO_OLD") << cursor;
  }
}

TEST_F(WatchServiceTest, RefusesARateOrATopicThatThereIsNot) {
  for (const double hz : {-1.0, 21.0, std::nan("")}) {
    Call call;
    v1::WatchRequest request;
    request.set_max_hz(hz);
    const auto reader = WatchStub(channel).Watch(&call, request);
    v1::WatchResponse batch;
    EXPECT_FALSE(reader->Read(&batch));
    EXPECT_EQ(rpc::to_error(reader->Finish()).reason, "BAD_RATE");
  }
}

TEST_F(WatchServiceTest, ManyClientsCostTheCellOneLook) {
  std::vector<std::unique_ptr<Call>> calls;
  std::vector<std::unique_ptr<grpc::ClientReader<v1::WatchResponse>>> readers;
  WatchStub stub(channel);
  for (int i = 0; i < 10; ++i) {
    calls.push_back(std::make_unique<Call>());
    readers.push_back(stub.Watch(calls.back().get(), v1::WatchRequest{}));
    v1::WatchResponse batch;
    ASSERT_TRUE(readers.back()->Read(&batch));
  }
  EXPECT_EQ(feeds.records.now, 1) << "one look for all";
  add_event("news");
  for (auto& reader : readers) {
    v1::WatchResponse batch;
    bool told = false;
    while (!told && reader->Read(&batch))
      for (const auto& event : batch.events()) told = told || event.has_record();
    EXPECT_TRUE(told);
  }
  EXPECT_EQ(feeds.records.begun, 1);
  for (auto& call : calls) call->TryCancel();
}

TEST_F(WatchServiceTest, AlarmsAreListedAndAcknowledgedOneByOne) {
  const AlarmId lost = cell.on_store([](Store& store) {
    AlarmRecord alarm;
    alarm.level = AlarmLevel::warning;
    alarm.kind = "channel.stale";
    alarm.subject = "t07_degC";
    alarm.message = "old";
    alarm.since = {6};
    EXPECT_TRUE(store.alarms().raise(alarm));
    alarm.level = AlarmLevel::failed;
    alarm.kind = "device.lost";
    alarm.subject = "laser-x";
    alarm.message = "it is gone";
    alarm.consequences = {"run 3 waits"};
    return store.alarms().raise(alarm)->id;
  });
  v1::AcknowledgeAlarmRequest request;
  request.set_alarm_id(lost.value);
  const auto done = ask(&WatchStub::AcknowledgeAlarm, request, "ada");
  ASSERT_TRUE(done);
  EXPECT_EQ(done->alarm().acknowledged_by(), "ada");
  const auto list = ask(&WatchStub::ListAlarms, v1::ListAlarmsRequest{});
  ASSERT_EQ(list->alarms_size(), 2);
  EXPECT_TRUE(list->alarms(0).has_acknowledge_time());
  ASSERT_EQ(list->alarms(0).consequences_size(), 1);
  EXPECT_EQ(list->alarms(0).consequences(0), "run 3 waits");
  EXPECT_FALSE(list->alarms(1).has_acknowledge_time());
  request.set_alarm_id(99);
  EXPECT_THAT(ask(&WatchStub::AcknowledgeAlarm, request),
              FailsWith(ErrorCode::not_found, "NO_SUCH_ALARM"));
}

class FullDiskTest : public WatchServiceTest {
 protected:
  FullDiskTest() { fakes.alarms = &alarms; }
  static AlarmRecord lost(CellTime cleared = {}) {
    AlarmRecord alarm;
    alarm.level = AlarmLevel::failed;
    alarm.kind = "device.lost";
    alarm.subject = "laser-x";
    alarm.message = "it is gone";
    alarm.since = {6};
    alarm.cleared = cleared;
    return alarm;
  }
  void now_missing(std::vector<AlarmRecord> missing) {
    cell.on_executor([&] { alarms.missing = std::move(missing); });
  }
  // The next alarm of this stream.
  static v1::Alarm next_of(grpc::ClientReader<v1::WatchResponse>& reader) {
    v1::WatchResponse batch;
    while (reader.Read(&batch))
      for (const auto& event : batch.events())
        if (event.has_alarm()) return event.alarm();
    ADD_FAILURE() << "the stream ended";
    return {};
  }
  FakeAlarms alarms;
};

TEST_F(FullDiskTest, AnAlarmThatIsNotOnRecordIsToldToThoseWhoWatchAndToThoseWhoComeMeanwhile) {
  WatchStub stub(channel);
  Call first_call, second_call;
  const auto first = stub.Watch(&first_call, v1::WatchRequest{});
  v1::WatchResponse batch;
  ASSERT_TRUE(first->Read(&batch));
  now_missing({lost()});
  const auto told = next_of(*first);
  EXPECT_EQ(told.id(), 0);
  EXPECT_EQ(told.subject(), "laser-x");
  const auto second = stub.Watch(&second_call, v1::WatchRequest{});
  EXPECT_EQ(next_of(*second).SerializeAsString(), told.SerializeAsString());
  now_missing({lost({7})});
  for (auto* reader : {first.get(), second.get()})
    EXPECT_TRUE(next_of(*reader).has_cleared_time()) << "it is over";
  first_call.TryCancel();
  second_call.TryCancel();
}

// A client goes by what it reads last.
TEST_F(FullDiskTest, WhatIsNewerThanTheRecordIsToldBehindIt) {
  const std::string cursor = cursor_now();
  AlarmRecord stored = cell.on_store([](Store& store) { return *store.alarms().raise(lost()); });
  cell.on_executor([&] { feeds.records.publish(); });
  stored.cleared = {7};
  now_missing({stored});
  Call call;
  WatchStub stub(channel);
  v1::WatchRequest request;
  request.set_cursor(cursor);
  const auto reader = stub.Watch(&call, request);
  std::vector<bool> over;
  v1::WatchResponse batch;
  while (over.size() < 2 && reader->Read(&batch))
    for (const auto& event : batch.events())
      if (event.has_alarm()) over.push_back(event.alarm().has_cleared_time());
  EXPECT_THAT(over, testing::ElementsAre(false, true));
  call.TryCancel();
}

TEST_F(WatchServiceTest, AShelfKeepsItsReasonAsOneLineOfBoundedLength) {
  const AlarmId stale = cell.on_store([](Store& store) {
    AlarmRecord alarm;
    alarm.kind = "channel.stale";
    alarm.subject = "t07_degC";
    alarm.message = "old";
    alarm.since = {6};
    return store.alarms().raise(alarm)->id;
  });
  v1::ShelveAlarmRequest request;
  request.set_alarm_id(stale.value);
  request.mutable_shelve_duration()->set_seconds(60);
  request.set_reason(std::string(33 << 19, 'x'));
  EXPECT_THAT(ask(&WatchStub::ShelveAlarm, request),
              FailsWith(ErrorCode::invalid_argument, "TOO_LONG"));
  request.set_reason("the probe is out\nfor cleaning\x1b[2J");
  const auto shelved = ask(&WatchStub::ShelveAlarm, request);
  ASSERT_TRUE(shelved) << shelved.error().message;
  EXPECT_EQ(shelved->alarm().shelve_reason(), "the probe is out for cleaning?[2J");
}

TEST_F(WatchServiceTest, ASeriesKeepsWhatFloatsWouldLose) {
  cell.on_store([](Store& store) {
    std::vector<Reading> readings;
    for (int i = 0; i < 2; ++i) {
      const CellTime at{1'700'000'000'000'000'000 + i};
      readings.push_back({"laser-y", at, at, i, {{"y_mm", 10.000000001 + 2e-9 * i}}});
    }
    ASSERT_TRUE(store.readings().append(readings, {}));
  });
  v1::GetSeriesRequest request;
  request.add_channels("y_mm");
  request.set_bucket_count(2);
  request.mutable_from_time()->set_seconds(1'700'000'000);
  request.mutable_to_time()->set_seconds(1'700'000'020);
  const auto answer = ask(&WatchStub::GetSeries, request);
  ASSERT_TRUE(answer);
  const auto& series = answer->series(0);
  EXPECT_EQ(series.unit(), "mm");
  EXPECT_NEAR(series.base() + static_cast<double>(series.min(0)), 10.000000001, 1e-12);
  EXPECT_NEAR(series.base() + static_cast<double>(series.max(0)), 10.000000003, 1e-12);
  EXPECT_TRUE(std::isnan(series.mean(1)));
  EXPECT_FALSE(answer->raw());
}

TEST_F(WatchServiceTest, AChannelWithoutARecordTakesNoOtherSeriesAway) {
  cell.on_store([](Store& store) {
    const CellTime at{1'700'000'000'000'000'000};
    const std::vector<Reading> readings{{"old", at, at, 0, {{"t91_degC", 20.5}}}};
    ASSERT_TRUE(store.readings().append(readings, {}));
  });
  v1::GetSeriesRequest request;
  for (const char* name : {"t91_degC", "x_mm", "t99_degC"}) request.add_channels(name);
  request.set_bucket_count(2);
  request.mutable_from_time()->set_seconds(1'699'999'990);
  request.mutable_to_time()->set_seconds(1'700'000'010);
  const auto answer = ask(&WatchStub::GetSeries, request);
  ASSERT_TRUE(answer) << answer.error().message;
  ASSERT_EQ(answer->series_size(), 2);
  EXPECT_EQ(answer->series(0).channel(), "t91_degC") << "of a thermometer that is gone";
  EXPECT_EQ(answer->series(1).channel(), "x_mm") << "of the layout, not recorded yet";
  EXPECT_EQ(answer->series(1).count_size(), answer->series(0).count_size());
  ASSERT_EQ(answer->unknown_channels_size(), 1);
  EXPECT_EQ(answer->unknown_channels(0), "t99_degC");

  request.clear_channels();
  request.add_channels("t99_degC");
  EXPECT_THAT(ask(&WatchStub::GetSeries, request),
              FailsWith(ErrorCode::invalid_argument, "NO_SUCH_CHANNEL"));
}

TEST_F(WatchServiceTest, ASeriesRequestNamesWhatIsWrong) {
  const auto reason = [&](auto change) {
    v1::GetSeriesRequest request;
    request.add_channels("x_mm");
    request.set_bucket_count(100);
    change(request);
    const auto answer = ask(&WatchStub::GetSeries, request);
    return answer ? "" : answer.error().reason;
  };
  EXPECT_EQ(reason([](auto& r) { r.clear_channels(); }), "BAD_CHANNEL");
  EXPECT_EQ(reason([](auto& r) { r.add_channels("x"); }), "BAD_CHANNEL");
  EXPECT_EQ(reason([](auto& r) { r.add_channels("x_mm"); }), "BAD_CHANNEL");
  EXPECT_EQ(reason([](auto& r) { r.set_bucket_count(0); }), "BAD_BUCKETS");
  EXPECT_EQ(reason([](auto& r) { r.set_bucket_count(10'001); }), "BAD_BUCKETS");
  EXPECT_EQ(reason([](auto& r) {
              r.mutable_from_time()->set_seconds(10);
              r.mutable_to_time()->set_seconds(10);
            }),
            "BAD_RANGE");
  EXPECT_EQ(reason([](auto& r) { r.mutable_to_time()->set_nanos(-1); }), "BAD_TIME");
  EXPECT_EQ(reason([](auto& r) {
              for (int i = 0; i < 150; ++i) r.add_channels("t" + std::to_string(i) + "_degC");
              r.set_bucket_count(10'000);
            }),
            "TOO_MANY_BUCKETS");
}

}  // namespace
}  // namespace driftwise::tests
