// Progress of a job comes from the cell, its making and its end from the record: together they
// never run backwards.

#include "server/rpc/watch/jobs_told.h"

#include <gtest/gtest.h>

namespace driftwise::rpc {
namespace {

v1::WatchEvent diagnosis_event(std::int64_t id, v1::Diagnosis::State state, const std::string& step,
                               double fraction) {
  v1::WatchEvent event;
  auto& job = *event.mutable_diagnosis();
  job.set_diagnosis_id(id);
  job.set_state(state);
  job.set_step(step);
  job.set_fraction(fraction);
  return event;
}
v1::WatchEvent improvement_event(std::int64_t id, v1::Improvement::State state, int turn,
                                 const std::string& step) {
  v1::WatchEvent event;
  auto& job = *event.mutable_improvement();
  job.set_improvement_id(id);
  job.set_state(state);
  job.set_turn(turn);
  job.set_step(step);
  return event;
}

TEST(JobsTold, TheRecordDoesNotTakeProgressBack) {
  JobsTold told;
  EXPECT_TRUE(told.from_cell(diagnosis_event(3, v1::Diagnosis::STATE_RUNNING, "q1", 0.4)));
  EXPECT_FALSE(told.from_record(diagnosis_event(3, v1::Diagnosis::STATE_RUNNING, "", 0)));
}

TEST(JobsTold, WhoReturnsHearsFromTheRecordThatAJobRunsAndOnlyOnce) {
  JobsTold told;
  EXPECT_TRUE(told.from_record(diagnosis_event(3, v1::Diagnosis::STATE_RUNNING, "", 0)));
  EXPECT_FALSE(told.from_record(diagnosis_event(3, v1::Diagnosis::STATE_RUNNING, "", 0)));
  EXPECT_TRUE(told.from_cell(diagnosis_event(3, v1::Diagnosis::STATE_RUNNING, "q1", 0.4)));
}

TEST(JobsTold, TheSameStateTwiceIsNoNews) {
  JobsTold told;
  const auto event = improvement_event(1, v1::Improvement::STATE_RUNNING, 2, "measuring");
  EXPECT_TRUE(told.from_cell(event));
  EXPECT_FALSE(told.from_cell(event));
}

TEST(JobsTold, AnEndIsAlwaysToldAndKeepsTheFractionThatWasReached) {
  JobsTold told;
  EXPECT_TRUE(told.from_cell(diagnosis_event(3, v1::Diagnosis::STATE_RUNNING, "q1", 0.7)));
  const auto end =
      told.from_record(diagnosis_event(3, v1::Diagnosis::STATE_CANCELLED, "cancelled by ada", 0));
  ASSERT_TRUE(end);
  EXPECT_EQ(end->diagnosis().fraction(), 0.7);
  // Accepting what was found says so of one that is over.
  EXPECT_TRUE(told.from_record(diagnosis_event(3, v1::Diagnosis::STATE_DONE, "done", 1)));
  EXPECT_TRUE(told.from_record(diagnosis_event(3, v1::Diagnosis::STATE_DONE, "done", 1)));
}

TEST(JobsTold, AStoredTurnIsToldWithTheStepTheLoopIsAt) {
  JobsTold told;
  EXPECT_TRUE(
      told.from_cell(improvement_event(1, v1::Improvement::STATE_RUNNING, 2, "diagnosing")));
  const auto turn = told.from_record(improvement_event(1, v1::Improvement::STATE_RUNNING, 1, ""));
  ASSERT_TRUE(turn);
  EXPECT_EQ(turn->improvement().step(), "diagnosing");
  EXPECT_EQ(turn->improvement().turn(), 2);
}

TEST(JobsTold, OtherEventsPass) {
  JobsTold told;
  v1::WatchEvent event;
  event.mutable_model()->set_model_id(4);
  EXPECT_TRUE(told.from_cell(event));
  EXPECT_TRUE(told.from_record(event));
  EXPECT_TRUE(told.from_record(event));
}

}  // namespace
}  // namespace driftwise::rpc
