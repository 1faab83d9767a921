#include <limits>

#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/data_service.grpc.pb.h"
#include "driftwise/v1/run_service.grpc.pb.h"
#include "server/application/ports/run_plan.h"
#include "server/formats/csv/dataset_csv.h"
#include "tests/unit/rpc/rpc_fixture.h"

namespace driftwise::tests {
namespace {

using RunStub = v1::RunService::Stub;

class RunServiceTest : public RpcTest {
 protected:
  v1::CreateRunRequest a_run() {
    v1::CreateRunRequest request;
    request.set_name("weekend");
    request.set_trajectory_name("weekend.csv");
    request.set_trajectory_text("q1_mm\n0\n1\n0\n");
    request.set_lease_token(ask(&v1::CellService::Stub::TakeLease, {})->lease().token());
    return request;
  }
};

TEST_F(RunServiceTest, ChecksATrajectoryAndNamesWhatIsWrong) {
  v1::CheckTrajectoryRequest request;
  request.set_trajectory_text("q1_mm\n0\n1\n0\n");
  const auto check = ask(&RunStub::CheckTrajectory, request);
  ASSERT_TRUE(check);
  EXPECT_EQ(check->row_count(), 3);
  EXPECT_EQ(check->coordinates(0), "q1_mm");
  EXPECT_GT(check->estimated_duration().seconds(), 3);
  request.set_trajectory_text("q1_mm\nbad\n");
  EXPECT_THAT(ask(&RunStub::CheckTrajectory, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_NUMBER"));
}

TEST_F(RunServiceTest, CreatesARunAsItWasAskedFor) {
  auto request = a_run();
  request.mutable_rules()->set_readings_per_point(6);
  request.mutable_rules()->mutable_settle_duration()->set_nanos(500'000'000);
  const auto created = ask(&RunStub::CreateRun, request);
  ASSERT_TRUE(created);
  EXPECT_EQ(created->run().operator_name(), "ada");
  EXPECT_FALSE(created->run().has_end_time());
  v1::GetRunRequest kept;
  kept.set_run_id(created->run().id());
  const auto run = ask(&RunStub::GetRun, kept);
  ASSERT_TRUE(run);
  EXPECT_EQ(run->trajectory_text(), "q1_mm\n0\n1\n0\n");
  const auto plan = app::read_run_plan(run->rules_json());
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->rules.readings_per_point, 6);
  EXPECT_DOUBLE_EQ(plan->rules.settle_s, 0.5);
  EXPECT_DOUBLE_EQ(plan->rules.quiet_nm, 80)
      << "what the request leaves out is as in the cell file";
}

TEST_F(RunServiceTest, CompensatesWithTheModelThatIsNamed) {
  auto request = a_run();
  request.set_trajectory_text("x_mm\n0\n1\n0\n");
  request.set_compensate(true);
  request.set_compensate_model_id(7);
  EXPECT_THAT(ask(&RunStub::CreateRun, request), FailsWith(ErrorCode::not_found, "NO_SUCH_MODEL"));
  request.set_compensate_model_id(cell.add_model("q ~ x").value);
  const auto created = ask(&RunStub::CreateRun, request);
  EXPECT_TRUE(created) << created.error().message;
}

TEST_F(RunServiceTest, ARepeatedRequestAnswersWithTheFirstRun) {
  auto request = a_run();
  request.set_request_id("once");
  const auto first = ask(&RunStub::CreateRun, request), second = ask(&RunStub::CreateRun, request);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->run().id(), second->run().id());
}

TEST_F(RunServiceTest, RefusesARequestThatCannotBeMeant) {
  const auto good = a_run();
  auto request = good;
  request.clear_trajectory_text();
  EXPECT_THAT(ask(&RunStub::CreateRun, request),
              FailsWith(ErrorCode::invalid_argument, "EMPTY_TRAJECTORY"));
  request = good;
  request.set_request_id(std::string(129, 'r'));
  EXPECT_THAT(ask(&RunStub::CreateRun, request),
              FailsWith(ErrorCode::invalid_argument, "TOO_LONG"));
  request = good;
  request.set_trajectory_text(std::string(9 << 20, '1'));
  EXPECT_THAT(ask(&RunStub::CreateRun, request),
              FailsWith(ErrorCode::invalid_argument, "TOO_LONG"));
  request = good;
  request.set_compensate_model_id(1);
  EXPECT_THAT(ask(&RunStub::CreateRun, request),
              FailsWith(ErrorCode::invalid_argument, "MODEL_WITHOUT_COMPENSATE"));
  request.set_compensate(true);
  request.set_compensate_model_id(-4);
  EXPECT_THAT(ask(&RunStub::CreateRun, request), FailsWith(ErrorCode::invalid_argument, "BAD_ID"));
  for (const double bad : {std::nan(""), -1.0, 1e300, std::numeric_limits<double>::infinity()}) {
    request = good;
    request.mutable_rules()->set_max_spread_nm(bad);
    EXPECT_THAT(ask(&RunStub::CreateRun, request),
                FailsWith(ErrorCode::invalid_argument, "BAD_RULE"))
        << bad;
  }
  request = good;
  request.mutable_rules()->set_readings_per_point(INT32_MAX);
  EXPECT_THAT(ask(&RunStub::CreateRun, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_RULE"));
  request = good;
  request.mutable_rules()->mutable_settle_duration()->set_nanos(-5);
  EXPECT_THAT(ask(&RunStub::CreateRun, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_DURATION"));
  request = good;
  request.set_lease_token("wrong");
  EXPECT_THAT(ask(&RunStub::CreateRun, request),
              FailsWith(ErrorCode::permission_denied, "LEASE_HELD"));
  EXPECT_EQ(ask(&RunStub::ListRuns, {})->runs_size(), 0) << "nothing is half-done";
}

class SteeredRun : public RpcTest {
 protected:
  SteeredRun() {
    fakes.runs = &runs;
    runs.add(1);
  }
  FakeRuns runs;
};

TEST_F(SteeredRun, ConfirmsAForceThatWasSaid) {
  v1::ConfirmForceRequest request;
  request.set_run_id(1);
  EXPECT_THAT(ask(&RunStub::ConfirmForce, request),
              FailsWith(ErrorCode::invalid_argument, "MISSING_FORCE"));
  request.set_force_n(std::numeric_limits<double>::infinity());
  EXPECT_THAT(ask(&RunStub::ConfirmForce, request),
              FailsWith(ErrorCode::invalid_argument, "MISSING_FORCE"));
  request.set_force_n(0);
  EXPECT_TRUE(ask(&RunStub::ConfirmForce, request)) << "no force is a force that can be confirmed";
  request.set_run_id(7);
  EXPECT_THAT(ask(&RunStub::ConfirmForce, request), FailsWith(ErrorCode::not_found, "NO_SUCH_RUN"));
}

TEST_F(RunServiceTest, ShowsARunWithItsTrajectoryAndItsRules) {
  ASSERT_TRUE(ask(&RunStub::CreateRun, a_run()));
  v1::GetRunRequest request;
  request.set_run_id(1);
  const auto run = ask(&RunStub::GetRun, request);
  ASSERT_TRUE(run);
  EXPECT_EQ(run->run().name(), "weekend");
  EXPECT_EQ(run->trajectory_text(), "q1_mm\n0\n1\n0\n");
  EXPECT_THAT(run->rules_json(), testing::HasSubstr("settle_s"));
}

TEST_F(RunServiceTest, SaysWhichIdIsBadAndWhichUnknown) {
  v1::GetRunRequest request;
  for (const std::int64_t bad : {std::int64_t{0}, std::int64_t{-1}, INT64_MIN}) {
    request.set_run_id(bad);
    EXPECT_THAT(ask(&RunStub::GetRun, request), FailsWith(ErrorCode::invalid_argument, "BAD_ID"));
  }
  request.set_run_id(999);
  EXPECT_THAT(ask(&RunStub::GetRun, request), FailsWith(ErrorCode::not_found, "NO_SUCH_RUN"));
  v1::PauseRunRequest pause;
  pause.set_run_id(999);
  EXPECT_THAT(ask(&RunStub::PauseRun, pause), FailsWith(ErrorCode::not_found, "NO_SUCH_RUN"));
  v1::ListAttemptsRequest attempts;
  attempts.set_run_id(999);
  EXPECT_THAT(ask(&RunStub::ListAttempts, attempts),
              FailsWith(ErrorCode::not_found, "NO_SUCH_RUN"));
  v1::ListDatumsRequest datums;
  EXPECT_THAT(ask(&RunStub::ListDatums, datums), FailsWith(ErrorCode::invalid_argument, "BAD_ID"));
}

TEST_F(SteeredRun, PausesResumesAndAbortsForAnybody) {
  v1::PauseRunRequest pause;
  pause.set_run_id(1);
  EXPECT_EQ(ask(&RunStub::PauseRun, pause, "bob")->run().reason(), "paused by bob");
  v1::ResumeRunRequest resume;
  resume.set_run_id(1);
  EXPECT_EQ(ask(&RunStub::ResumeRun, resume, "bob")->run().state(), v1::Run::STATE_RUNNING);
  v1::AbortRunRequest abort;
  abort.set_run_id(1);
  abort.set_reason("door open");
  EXPECT_EQ(ask(&RunStub::AbortRun, abort, "bob")->run().state(), v1::Run::STATE_ABORTED);
  EXPECT_THAT(ask(&RunStub::PauseRun, pause),
              FailsWith(ErrorCode::failed_precondition, "RUN_OVER"));
}

TEST_F(RunServiceTest, PagesThroughRunsAndPoints) {
  for (int i = 1; i <= 7; ++i) cell.add_run();
  PointRecord point;
  point.values = {{"x_mm", 1.5}, {"t07_degC", kMissing}};
  cell.add_points(RunId{1}, std::vector<PointRecord>(7, point));
  v1::ListRunsRequest runs;
  runs.set_limit(3);
  runs.set_before_run_id(5);
  const auto page = ask(&RunStub::ListRuns, runs);
  ASSERT_TRUE(page);
  ASSERT_EQ(page->runs_size(), 3);
  EXPECT_EQ(page->runs(0).id(), 4);
  v1::ListPointsRequest points;
  points.set_run_id(1);
  points.set_after_point_id(5);
  const auto found = ask(&RunStub::ListPoints, points);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->points_size(), 2);
  // The record counts rows from 0, the API and every client from 1.
  EXPECT_EQ(found->points(0).row(), 6);
  EXPECT_FALSE(found->points(0).values(1).has_value());
  points.set_limit(10001);
  EXPECT_THAT(ask(&RunStub::ListPoints, points),
              FailsWith(ErrorCode::invalid_argument, "BAD_LIMIT"));
  runs.set_limit(-1);
  EXPECT_THAT(ask(&RunStub::ListRuns, runs), FailsWith(ErrorCode::invalid_argument, "BAD_LIMIT"));
}

TEST_F(SteeredRun, CarriesEveryKindOfErrorOfTheCell) {
  v1::GetRunRequest request;
  request.set_run_id(1);
  for (const ErrorCode code :
       {ErrorCode::already_exists, ErrorCode::failed_precondition, ErrorCode::aborted,
        ErrorCode::out_of_range, ErrorCode::resource_exhausted, ErrorCode::unavailable,
        ErrorCode::data_loss, ErrorCode::internal}) {
    cell.on_executor([&] { runs.fail_next = Error{code, "WHY", "what to do"}; });
    EXPECT_THAT(ask(&RunStub::GetRun, request), FailsWith(code, "WHY"));
  }
}

TEST_F(RunServiceTest, DatasetsGoOutInPiecesAndComeBackTheSame) {
  std::string csv = "q1_mm,x_mm\n";
  while (csv.size() < 300'000) csv += "0.123456789012345,0.2\n";
  v1::ImportDatasetRequest in;
  in.set_name("old");
  in.set_csv(csv);
  const auto run = ask(&v1::DataService::Stub::ImportDataset, in);
  ASSERT_TRUE(run);
  Call call;
  v1::ExportDatasetRequest out;
  out.add_run_ids(run->run().id());
  v1::DataService::Stub stub(channel);
  const auto reader = stub.ExportDataset(&call, out);
  std::string back;
  std::int64_t pieces = 0, total = 0;
  for (v1::ExportDatasetResponse piece; reader->Read(&piece); ++pieces) {
    EXPECT_LE(piece.chunk().size(), 65536U);
    total = piece.total_bytes();
    back += piece.chunk();
  }
  EXPECT_TRUE(reader->Finish().ok());
  EXPECT_EQ(std::ssize(back), total);
  EXPECT_EQ(pieces, (total + 65535) / 65536);
  const auto sent = formats::read_dataset_csv(csv, "sent"),
             kept = formats::read_dataset_csv(back, "kept");
  ASSERT_TRUE(sent && kept);
  ASSERT_EQ(kept->rows, sent->rows);
  EXPECT_EQ(kept->find("q1")->values, sent->find("q1")->values);
}

// The daemon keeps names of sets under this key; what a file says there is nothing of the kind.
TEST_F(RunServiceTest, TheSetsOfAnImportedFileAreThoseOfItsColumn) {
  for (const char* line : {"# set_names: outside*3\n", "# set_names: outside*100000000\n"}) {
    const std::string rows = "set,x_mm\ncalibration,1\ninside,2\nvalidation,3\n";
    v1::ImportDatasetRequest in;
    in.set_name("old");
    in.set_csv("# driftwise-dataset: 1\n" + std::string(line) + rows);
    const auto run = ask(&v1::DataService::Stub::ImportDataset, in);
    ASSERT_TRUE(run) << run.error().message;
    Call call;
    v1::ExportDatasetRequest out;
    out.add_run_ids(run->run().id());
    const auto reader = v1::DataService::Stub(channel).ExportDataset(&call, out);
    std::string back;
    for (v1::ExportDatasetResponse piece; reader->Read(&piece);) back += piece.chunk();
    EXPECT_TRUE(reader->Finish().ok());
    EXPECT_THAT(back, testing::HasSubstr("\ninside,2"));
    EXPECT_THAT(back, testing::Not(testing::HasSubstr("outside")));
  }
}

TEST_F(RunServiceTest, ExportRefusesNothingUnknownAndTwice) {
  const auto refused = [&](std::vector<std::int64_t> ids) {
    Call call;
    v1::ExportDatasetRequest request;
    for (const auto id : ids) request.add_run_ids(id);
    v1::DataService::Stub stub(channel);
    const auto reader = stub.ExportDataset(&call, request);
    v1::ExportDatasetResponse piece;
    EXPECT_FALSE(reader->Read(&piece));
    return rpc::to_error(reader->Finish()).reason;
  };
  EXPECT_EQ(refused({}), "NO_RUNS");
  EXPECT_EQ(refused({12}), "NO_SUCH_RUN");
  EXPECT_EQ(refused({-1}), "BAD_ID");
  EXPECT_EQ(refused({1, 1}), "DUPLICATE_RUN");
  EXPECT_EQ(refused(std::vector<std::int64_t>(2000, 1)), "TOO_MANY_RUNS");
}

}  // namespace
}  // namespace driftwise::tests
