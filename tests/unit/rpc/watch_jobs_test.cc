// Diagnoses and improvements in the Watch stream: a page that is open while somebody else starts
// one sees it move and end; one that slept hears how it ended.

#include "driftwise/v1/watch_service.grpc.pb.h"
#include "tests/unit/rpc/rpc_fixture.h"

namespace driftwise::tests {
namespace {

class WatchJobsTest : public RpcTest {
 protected:
  WatchJobsTest() {
    fakes.feeds = &feeds;
    fakes.diagnoses = &diagnoses;
    fakes.improvements = &improvements;
    run = cell.add_run();
  }
  FakeFeeds feeds;
  FakeDiagnoses diagnoses;
  FakeImprovements improvements;
  RunId run;
  struct Page {  // one that is open
    Call call;
    std::unique_ptr<grpc::ClientReader<v1::WatchResponse>> reader;
    std::string cursor;
  };
  std::unique_ptr<Page> open(const std::string& cursor = "") {
    auto page = std::make_unique<Page>();
    v1::WatchRequest request;
    request.set_cursor(cursor);
    request.set_max_hz(20);
    request.add_topics(v1::TOPIC_DIAGNOSES);
    page->reader = v1::WatchService::Stub(channel).Watch(&page->call, request);
    return page;
  }
  // Reads until this holds of an event; nothing when the stream ends before.
  static std::optional<v1::WatchEvent> until(
      Page& page, const std::function<bool(const v1::WatchEvent&)>& holds) {
    v1::WatchResponse batch;
    while (page.reader->Read(&batch)) {
      page.cursor = batch.cursor();
      for (const auto& event : batch.events())
        if (holds(event)) return event;
    }
    return std::nullopt;
  }
  static std::string cursor_of(Page& page) {
    v1::WatchResponse batch;
    EXPECT_TRUE(page.reader->Read(&batch));
    return batch.cursor();
  }
  // As the store and the desk do it: on record first, then told.
  void change(DiagnosisChange what, const std::string& step, double fraction) {
    cell.on_executor([&] {
      auto& store = cell.store().diagnoses();
      if (what.state == JobState::running) {
        DiagnosisRecord record;
        record.runs = {run};
        record.created = kWorldBegin;
        ASSERT_EQ(store.add_diagnosis(record)->id, what.id);
      } else {
        ASSERT_TRUE(
            store.end_diagnosis(what.id, {what.state, what.reason, "", "", "", kWorldBegin}));
      }
      diagnoses.progress.publish({what.id, what.state, step, fraction});
      feeds.records.publish();
    });
  }
};

const auto kIsDiagnosis = [](const v1::WatchEvent& event) { return event.has_diagnosis(); };

TEST_F(WatchJobsTest, AnOpenPageSeesADiagnosisThatSomebodyElseStarts) {
  const auto page = open();
  cursor_of(*page);
  change({DiagnosisId{1}, JobState::running, ""}, "waiting for its turn", 0);
  auto seen = until(*page, kIsDiagnosis);
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->diagnosis().diagnosis_id(), 1);
  EXPECT_EQ(seen->diagnosis().state(), v1::Diagnosis::STATE_RUNNING);
  cell.on_executor([&] {
    diagnoses.progress.publish(
        {DiagnosisId{1}, JobState::running, "looking for a cause in q1", 0.6});
  });
  seen = until(*page, [](const v1::WatchEvent& event) { return event.diagnosis().fraction() > 0; });
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->diagnosis().step(), "looking for a cause in q1");
  change({DiagnosisId{1}, JobState::done, ""}, "done", 1);
  seen = until(*page, [](const v1::WatchEvent& event) {
    return event.diagnosis().state() == v1::Diagnosis::STATE_DONE;
  });
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->diagnosis().fraction(), 1);
  page->call.TryCancel();
}

TEST_F(WatchJobsTest, APageThatOpensMeanwhileBeginsWithWhatIsUnderWay) {
  const auto first = open();
  cursor_of(*first);
  change({DiagnosisId{1}, JobState::running, ""}, "looking for a cause in q1", 0.3);
  ASSERT_TRUE(until(*first, kIsDiagnosis));
  const auto second = open();
  const auto seen = until(*second, kIsDiagnosis);
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->diagnosis().diagnosis_id(), 1);
  EXPECT_EQ(seen->diagnosis().step(), "looking for a cause in q1");
  first->call.TryCancel();
  second->call.TryCancel();
}

TEST_F(WatchJobsTest, APageThatSleptHearsHowItEndedByItsCursor) {
  const auto before = open();
  const std::string cursor = cursor_of(*before);
  before->call.TryCancel();
  change({DiagnosisId{1}, JobState::running, ""}, "waiting for its turn", 0);
  change({DiagnosisId{1}, JobState::failed, "the daemon ended while it ran"},
         "the daemon ended while it ran", 0);
  const auto after = open(cursor);
  const auto seen = until(*after, [](const v1::WatchEvent& event) {
    return event.diagnosis().state() == v1::Diagnosis::STATE_FAILED;
  });
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->diagnosis().step(), "the daemon ended while it ran");
  after->call.TryCancel();
}

TEST_F(WatchJobsTest, TheTurnsOfAnImprovementAreToldOneByOne) {
  cell.on_store([](Store& store) {
    ImprovementRecord record;
    record.created = kWorldBegin;
    ASSERT_TRUE(store.improvements().add_improvement(record));
  });
  const auto page = open();
  cursor_of(*page);
  for (const int turn : {1, 2}) {
    cell.on_executor([&] {
      improvements.progress.publish({ImprovementId{1}, JobState::running, turn, "measuring"});
    });
    const auto seen = until(
        *page, [&](const v1::WatchEvent& event) { return event.improvement().turn() == turn; });
    ASSERT_TRUE(seen) << turn;
    EXPECT_EQ(seen->improvement().step(), "measuring");
  }
  cell.on_executor([&] {
    const std::string why = "nothing beyond noise is left";
    ASSERT_TRUE(cell.store().improvements().end_improvement({1}, JobState::done, why, kWorldBegin));
    improvements.progress.publish({ImprovementId{1}, JobState::done, 2, why});
    feeds.records.publish();
  });
  const auto end = until(*page, [](const v1::WatchEvent& event) {
    return event.improvement().state() == v1::Improvement::STATE_DONE;
  });
  ASSERT_TRUE(end);
  EXPECT_EQ(end->improvement().step(), "nothing beyond noise is left");
  page->call.TryCancel();
}

}  // namespace
}  // namespace driftwise::tests
