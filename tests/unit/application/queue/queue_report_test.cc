// The reports that a queue's entries leave beside the database.

#include <gmock/gmock.h>

#include "tests/unit/application/queue/queue_cell.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

TEST_F(QueueTest, WritesAReportBesideTheDatabase) {
  write_template();
  auto d = draft("night");
  d.metadata = {{"sample", "A12"}};
  d.follow_ups = {"report"};
  const auto a = add(d);
  until(a, QueueState::done);
  const auto path = folder / "reports/queue-1-run-1.html";
  EXPECT_THAT(look(a).results.at(0).text, HasSubstr("the report " + path + " was written"));
  const auto report = report_in(path);
  EXPECT_EQ(report["run"]["accepted"], 3);
  EXPECT_EQ(report["run"]["metadata"]["sample"], "A12");
  EXPECT_EQ(report["points"]["count"], 3);
  EXPECT_THAT(report["run"]["start"].get<std::string>(), HasSubstr("2026-11-21T08:"));
  EXPECT_EQ(report["queue"]["entry"], 1);
}

TEST_F(QueueTest, TheReportTellsOfTheEntriesThatItCameAfterWithTheirFitAndTheirAlarms) {
  write_template();
  auto first = draft("friday");
  first.trajectory_text = kShort + "0,calibration,1,1\n";
  first.follow_ups = {"notify"};
  const auto a = add(first);
  auto second = draft("saturday");
  second.trajectory_text = lines_of(2, {-4, -2, -1, 1, 2, 4}, true);
  second.after = a.entry.id;
  second.follow_ups = {"fit:q ~ x", "report"};
  const auto b = add(second);
  until(a, QueueState::done);
  const auto alarms = cell.await(cell->alarms.list(false, 10));
  const auto told = std::ranges::find(*alarms, "queue.done", &AlarmRecord::kind);
  ASSERT_NE(told, alarms->end());
  ASSERT_TRUE(cell.await(cell->alarms.acknowledge({"bob", "", {}}, told->id)));
  until(b, QueueState::done);
  const auto report = report_in(folder / "reports/queue-2-run-2.html");
  const auto& entries = report["queue"]["entries"];
  ASSERT_EQ(entries.size(), 2u);
  EXPECT_EQ(entries[0]["name"], "friday");
  EXPECT_EQ(entries[0]["run_state"], "done");
  EXPECT_EQ(entries[1]["after"], 1);
  ASSERT_EQ(report["models"].size(), 1u);
  EXPECT_EQ(report["models"][0]["formula"], "q ~ x");
  EXPECT_EQ(report["models"][0]["residuals"][0]["output"], "q1");
  const auto alarm = std::ranges::find(report["alarms"], "queue.done", [](const auto& one) {
    return one["kind"].template get<std::string>();
  });
  ASSERT_NE(alarm, report["alarms"].end());
  EXPECT_EQ((*alarm)["acknowledged_by"], "bob");
}

TEST_F(QueueTest, AReportWithoutItsTemplateSaysWhatToInstall) {
  auto d = draft("night");
  d.follow_ups = {"report"};
  const auto a = add(d);
  until(a, QueueState::done);
  EXPECT_FALSE(look(a).results.at(0).good);
  EXPECT_THAT(look(a).results.at(0).text, HasSubstr("the page of reports was not found at "));
}

TEST_F(QueueTest, AReportThatCannotBeWrittenLosesNothingOfTheRun) {
  write_template();
  std::ofstream(folder / "reports") << "a file where the folder should be";
  auto d = draft("night");
  d.follow_ups = {"report"};
  const auto a = add(d);
  until(a, QueueState::done);
  EXPECT_FALSE(look(a).results.at(0).good);
  EXPECT_THAT(look(a).results.at(0).text, HasSubstr("cannot be written"));
  EXPECT_EQ(cell.await(cell.run(*look(a).run))->state, RunState::done);
}

}  // namespace
}  // namespace driftwise::tests
