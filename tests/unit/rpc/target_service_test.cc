#include "driftwise/v1/target_service.grpc.pb.h"
#include "tests/unit/rpc/rpc_fixture.h"

namespace driftwise::tests {
namespace {

using TargetStub = v1::TargetService::Stub;
using compensation::Snapshot;
using compensation::Variable;

// q1 = offset + x, with u = 10 nm from the fit; domain -4 .. 4 mm.
Snapshot line_snapshot(CellTime now, double offset_mm) {
  Snapshot snapshot;
  snapshot.model = {3};
  snapshot.built_at = now;
  snapshot.valid_until = now + std::chrono::seconds(30);
  snapshot.products = {{0, static_cast<std::uint8_t>(Variable::x)}};
  snapshot.needed = compensation::bit(Variable::x);
  snapshot.column_per_unit.fill(1.0);
  Snapshot::Output output;
  output.channel = {"q1", "mm"};
  output.coefficients_mm = {offset_mm, 1.0};
  output.variance_nm2 = {100.0, 0.0, 0.0};
  output.lines = {{compensation::UncertaintySource::fit, {100.0}}};
  snapshot.outputs = {output};
  Snapshot::Input x;
  x.channel = {"x", "mm"};
  x.variable = Variable::x;
  x.min = -4;
  x.max = 4;
  snapshot.inputs = {x};
  return snapshot;
}

v1::ComputeTargetRequest at(const std::string& channel, double value) {
  v1::ComputeTargetRequest request;
  auto& coordinate = *request.add_pose();
  coordinate.set_channel(channel);
  coordinate.set_value(value);
  return request;
}

class TargetServiceTest : public RpcTest {
 protected:
  TargetServiceTest() { fakes.targets = &targets; }
  FakeTargets targets;
  const CellTime the_time = cell.now();
  void serve(double offset_mm, std::function<void(Snapshot&)> change = {}) {
    cell.on_executor([&] {
      auto snapshot = line_snapshot(the_time, offset_mm);
      if (change) change(snapshot);
      targets.publish(std::move(snapshot));
    });
  }
};

TEST_F(TargetServiceTest, AnswersWithUncertaintyAndValidity) {
  serve(125e-6);
  const auto answer = ask(&TargetStub::ComputeTarget, at("x_mm", 1.5));
  ASSERT_TRUE(answer) << answer.error().message;
  const auto& target = answer->target();
  ASSERT_EQ(target.coordinates_size(), 1);
  EXPECT_EQ(target.coordinates(0).channel(), "q1_mm");
  EXPECT_DOUBLE_EQ(target.coordinates(0).position_mm(), 1.5 + 125e-6);
  EXPECT_DOUBLE_EQ(target.coordinates(0).u_nm(), 10.0);
  EXPECT_DOUBLE_EQ(target.coordinates(0).u90_nm(), 16.45);
  EXPECT_EQ(target.coordinates(0).budget_size(), 0);
  EXPECT_EQ(target.model_id(), 3);
  EXPECT_EQ(target.valid_until_time().seconds(), target.conditions_time().seconds() + 30);
  EXPECT_EQ(target.flags_size(), 0);
}

TEST_F(TargetServiceTest, EstimatesThePoseOfMotorCoordinates) {
  v1::EstimatePoseRequest request;
  request.add_motor()->set_channel("q1_mm");
  request.mutable_motor(0)->set_value(1.5 + 125e-6);
  EXPECT_FALSE(ask(&TargetStub::EstimatePose, request)) << "no model serves";
  serve(125e-6);
  const auto pose = ask(&TargetStub::EstimatePose, request);
  ASSERT_TRUE(pose) << pose.error().message;
  ASSERT_EQ(pose->coordinates_size(), 1);
  EXPECT_EQ(pose->coordinates(0).channel(), "x_mm");
  EXPECT_NEAR(pose->coordinates(0).value(), 1.5, 1e-13);
  EXPECT_NEAR(pose->coordinates(0).u(), 10e-6, 1e-15);
  EXPECT_FALSE(pose->coordinates(0).has_measured()) << "nobody stands there";
  EXPECT_EQ(pose->model_id(), 3);
  request.add_stated()->set_channel("z_mm");
  request.mutable_stated(0)->set_value(1);
  const auto stated = ask(&TargetStub::EstimatePose, request);
  ASSERT_TRUE(stated) << stated.error().message;
  EXPECT_THAT(stated->flags(), testing::Contains(v1::Target::FLAG_IGNORED_COORDINATE));
  EXPECT_THAT(stated->ignored_channels(), testing::ElementsAre("z_mm"));
  request.mutable_motor(0)->set_channel("q2_mm");
  EXPECT_THAT(ask(&TargetStub::EstimatePose, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_CHANNEL"));
}

TEST_F(TargetServiceTest, PutsWhatAnInstrumentReadsBesideThePoseOfNow) {
  const auto time = cell.passing();
  serve(125e-6);
  std::optional<v1::EstimatePoseResponse> pose;
  for (int tries = 0; tries < 2000 && !pose; ++tries) {  // until the devices were read once
    auto answer = ask(&TargetStub::EstimatePose, {});
    if (answer && answer->coordinates(0).has_measured())
      pose = *std::move(answer);
    else
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_TRUE(pose) << "the cell never read its axis and its interferometer";
  const auto& x = pose->coordinates(0);
  EXPECT_NEAR(x.value(), pose->motor(0).value() - 125e-6, 1e-13);
  EXPECT_NEAR(x.discrepancy(), x.measured() - x.value(), 1e-13);
  EXPECT_EQ(x.agrees(), std::abs(x.discrepancy()) <= 20e-6);
}

TEST_F(TargetServiceTest, TellsWhatTheUncertaintyIsMadeOfWhenAsked) {
  serve(0);
  auto request = at("x_mm", 1);
  request.set_with_budget(true);
  const auto answer = ask(&TargetStub::ComputeTarget, request);
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->target().coordinates(0).budget_size(), 1);
  EXPECT_EQ(answer->target().coordinates(0).budget(0).source(), v1::BudgetLine::SOURCE_FIT);
}

TEST_F(TargetServiceTest, TellsWhatTheCorrectionIsMadeOf) {
  serve(125e-6, [](Snapshot& snapshot) { snapshot.outputs[0].thermal_mm = {40e-6, 2e-6}; });
  auto request = at("x_mm", 1.5);
  request.set_with_budget(true);
  const auto answer = ask(&TargetStub::ComputeTarget, request);
  ASSERT_TRUE(answer);
  const auto& coordinate = answer->target().coordinates(0);
  EXPECT_NEAR(coordinate.correction_nm(), 125, 1e-6);
  ASSERT_EQ(coordinate.parts_size(), 3);
  EXPECT_NEAR(coordinate.parts(0).nm(), 82, 1e-6) << "geometry: 125 - 40 - 2 * 1.5";
  EXPECT_NEAR(coordinate.parts(1).nm(), 0, 1e-6);
  EXPECT_NEAR(coordinate.parts(2).nm(), 43, 1e-6);
}

TEST_F(TargetServiceTest, MapsTheCorrectionOverAPlane) {
  serve(125e-6);
  v1::MapTargetsRequest request;
  request.mutable_horizontal()->set_channel("x_mm");
  request.mutable_horizontal()->set_count(5);
  request.mutable_vertical()->set_channel("y_mm");
  request.mutable_vertical()->set_from(-1);
  request.mutable_vertical()->set_to(1);
  request.mutable_vertical()->set_count(3);
  const auto map = ask(&TargetStub::MapTargets, request);
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_DOUBLE_EQ(map->horizontal().from(), -4) << "the fitted domain, when nothing is stated";
  ASSERT_EQ(map->planes_size(), 1);
  ASSERT_EQ(map->planes(0).correction_nm_size(), 15);
  EXPECT_DOUBLE_EQ(map->planes(0).position_mm(1), -2 + 125e-6) << "row by row, x first";
  EXPECT_NEAR(map->planes(0).correction_nm(14), 125, 1e-6);
  EXPECT_FALSE(map->outside(0));
  request.mutable_vertical()->clear_to();
  EXPECT_THAT(ask(&TargetStub::MapTargets, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_AXIS"))
      << "the model knows no range of y";
  request.mutable_vertical()->set_channel("x_mm");
  EXPECT_THAT(ask(&TargetStub::MapTargets, request),
              FailsWith(ErrorCode::invalid_argument, "DUPLICATE_CHANNEL"));
}

TEST_F(TargetServiceTest, RefusesAPoseBeyondTheTravelAndShowsItToPeopleWithAMark) {
  serve(0, [](Snapshot& snapshot) {
    snapshot.outputs[0].min_mm = -0.2;
    snapshot.outputs[0].max_mm = 2.8;
  });
  auto request = at("x_mm", -801);
  EXPECT_THAT(ask(&TargetStub::ComputeTarget, request),
              FailsWith(ErrorCode::out_of_range, "OUTSIDE_LIMITS(q1)"));
  request.set_show_unreachable(true);
  const auto answer = ask(&TargetStub::ComputeTarget, request);
  ASSERT_TRUE(answer) << answer.error().message;
  const auto& target = answer->target();
  EXPECT_DOUBLE_EQ(target.coordinates(0).position_mm(), -801);
  EXPECT_DOUBLE_EQ(target.coordinates(0).min_mm(), -0.2);
  EXPECT_DOUBLE_EQ(target.coordinates(0).max_mm(), 2.8);
  EXPECT_THAT(target.flags(), testing::Contains(v1::Target::FLAG_OUTSIDE_LIMITS));
  EXPECT_THAT(target.unreachable_channels(), testing::ElementsAre("q1_mm"));
}

TEST_F(TargetServiceTest, NamesIgnoredCoordinatesAndUnknownLimits) {
  serve(0, [](Snapshot& snapshot) { snapshot.unlimited = 1; });
  auto request = at("x_mm", 1);
  request.add_pose()->set_channel("rx_arcsec");
  request.mutable_pose(1)->set_value(3);
  const auto answer = ask(&TargetStub::ComputeTarget, request);
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_THAT(answer->target().ignored_channels(), testing::ElementsAre("rx_arcsec"));
  EXPECT_THAT(answer->target().unlimited_channels(), testing::ElementsAre("q1_mm"));
}

TEST_F(TargetServiceTest, FlagsAPoseOutsideTheDomainByName) {
  serve(0);
  const auto answer = ask(&TargetStub::ComputeTarget, at("x_mm", 4.2));
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->target().flags_size(), 1);
  EXPECT_EQ(answer->target().flags(0), v1::Target::FLAG_OUTSIDE_DOMAIN);
  EXPECT_EQ(answer->target().outside_channels(0), "x_mm");
  EXPECT_GT(answer->target().coordinates(0).u_nm(), 10.0) << "and trusts it less";
}

TEST_F(TargetServiceTest, RefusesWhatTheCellRefuses) {
  EXPECT_THAT(ask(&TargetStub::ComputeTarget, at("x_mm", 1)),
              FailsWith(ErrorCode::failed_precondition, "NO_MODEL"));
  serve(0, [](Snapshot& snapshot) { snapshot.refuse_outside_domain = true; });
  EXPECT_THAT(ask(&TargetStub::ComputeTarget, at("x_mm", 99)),
              FailsWith(ErrorCode::out_of_range, "OUTSIDE_DOMAIN"));
  EXPECT_THAT(ask(&TargetStub::ComputeTarget, v1::ComputeTargetRequest{}),
              FailsWith(ErrorCode::invalid_argument, "MISSING_COORDINATE"));
}

TEST_F(TargetServiceTest, RefusesAPoseThatIsNone) {
  serve(0);
  EXPECT_THAT(ask(&TargetStub::ComputeTarget, at("x_mm", std::nan(""))),
              FailsWith(ErrorCode::invalid_argument, "NOT_FINITE"));
  for (const char* bad : {"q1_mm", "x", "x_um", "t07_degC", "rx_mm", "force_mm", "", "_mm"})
    EXPECT_THAT(ask(&TargetStub::ComputeTarget, at(bad, 1)),
                FailsWith(ErrorCode::invalid_argument, "BAD_POSE"))
        << bad;
  auto request = at("x_mm", 1);
  *request.add_pose() = request.pose(0);
  EXPECT_THAT(ask(&TargetStub::ComputeTarget, request),
              FailsWith(ErrorCode::invalid_argument, "DUPLICATE_CHANNEL"));
  request = at("x_mm", 1);
  request.mutable_pose(0)->clear_value();
  EXPECT_THAT(ask(&TargetStub::ComputeTarget, request),
              FailsWith(ErrorCode::invalid_argument, "MISSING_VALUE"));
}

TEST_F(TargetServiceTest, AStreamFollowsTheConditionsAndEndsWithTheClient) {
  serve(1e-6);
  Call call;
  v1::WatchTargetsRequest request;
  *request.mutable_pose() = at("x_mm", 1).pose();
  TargetStub stub(channel);
  const auto reader = stub.WatchTargets(&call, request);
  v1::WatchTargetsResponse response;
  ASSERT_TRUE(reader->Read(&response));
  EXPECT_DOUBLE_EQ(response.target().coordinates(0).position_mm(), 1 + 1e-6);
  serve(2e-6);
  ASSERT_TRUE(reader->Read(&response));
  EXPECT_DOUBLE_EQ(response.target().coordinates(0).position_mm(), 1 + 2e-6);
  call.TryCancel();
  reader->Finish();
  EXPECT_TRUE(eventually([&] { return targets.rebuilt.now == 0; }))
      << "the cancelled stream was noticed";
}

TEST_F(TargetServiceTest, AStreamWaitsItsIntervalAndThenTellsTheLatest) {
  serve(1e-6);
  Call call;
  v1::WatchTargetsRequest request;
  *request.mutable_pose() = at("x_mm", 1).pose();
  request.mutable_min_interval_duration()->set_nanos(200'000'000);
  TargetStub stub(channel);
  const auto reader = stub.WatchTargets(&call, request);
  v1::WatchTargetsResponse response;
  ASSERT_TRUE(reader->Read(&response));
  const auto began = std::chrono::steady_clock::now();
  for (int i = 2; i <= 9; ++i) serve(i * 1e-6);
  ASSERT_TRUE(reader->Read(&response));
  EXPECT_GE(std::chrono::steady_clock::now() - began, std::chrono::milliseconds(150));
  EXPECT_DOUBLE_EQ(response.target().coordinates(0).position_mm(), 1 + 9e-6);
}

TEST_F(TargetServiceTest, PastTargetsComeWithTheirTimesAndGapsStayGaps) {
  cell.on_executor([&] {
    targets.the_past.model = {3};
    targets.the_past.at = {the_time, the_time + std::chrono::seconds(30)};
    targets.the_past.tracks = {{{"q1", "mm"}, {-12.5, kMissing}}};
  });
  v1::ListPastTargetsRequest request;
  *request.mutable_pose() = at("x_mm", 1).pose();
  request.mutable_past_duration()->set_seconds(600);
  request.set_count(60);
  const auto answer = ask(&TargetStub::ListPastTargets, request);
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_EQ(answer->model_id(), 3);
  EXPECT_EQ(answer->times(1).seconds() - answer->times(0).seconds(), 30);
  EXPECT_EQ(answer->tracks(0).channel(), "q1_mm");
  EXPECT_EQ(answer->tracks(0).correction_nm(0), -12.5);
  EXPECT_TRUE(std::isnan(answer->tracks(0).correction_nm(1)));
  cell.on_executor([&] {
    EXPECT_EQ(targets.last_past.past, std::chrono::minutes(10));
    EXPECT_EQ(targets.last_past.count, 60);
  });
}

TEST_F(TargetServiceTest, ARequestForThePastNamesWhatIsWrong) {
  const auto reason = [&](auto change) {
    v1::ListPastTargetsRequest request;
    *request.mutable_pose() = at("x_mm", 1).pose();
    change(request);
    const auto answer = ask(&TargetStub::ListPastTargets, request);
    return answer ? "" : answer.error().reason;
  };
  EXPECT_EQ(reason([](auto&) {}), "");
  EXPECT_EQ(reason([](auto& r) { r.mutable_pose(0)->set_channel("t07_degC"); }), "BAD_POSE");
  EXPECT_EQ(reason([](auto& r) { r.mutable_past_duration()->set_seconds(59); }), "BAD_PAST");
  EXPECT_EQ(reason([](auto& r) { r.mutable_past_duration()->set_seconds(86'401); }), "BAD_PAST");
  EXPECT_EQ(reason([](auto& r) { r.set_count(501); }), "BAD_COUNT");
  EXPECT_EQ(reason([](auto& r) { r.set_count(-1); }), "BAD_COUNT");
}

TEST_F(TargetServiceTest, AStreamEndsWithTheReasonWhenNothingServes) {
  Call call;
  v1::WatchTargetsRequest request;
  *request.mutable_pose() = at("x_mm", 1).pose();
  TargetStub stub(channel);
  const auto reader = stub.WatchTargets(&call, request);
  v1::WatchTargetsResponse response;
  EXPECT_FALSE(reader->Read(&response));
  EXPECT_EQ(rpc::to_error(reader->Finish()).reason, "NO_MODEL");
}

}  // namespace
}  // namespace driftwise::tests
