#include "driftwise/v1/cell_service.grpc.pb.h"
#include "server/rpc/cell/convert_cell.h"
#include "tests/unit/rpc/rpc_fixture.h"

namespace driftwise::tests {
namespace {

using CellStub = v1::CellService::Stub;

class CellServiceTest : public RpcTest {
 protected:
  std::string lease() { return ask(&CellStub::TakeLease, v1::TakeLeaseRequest{})->lease().token(); }
  void home() {
    v1::HomeRequest request;
    request.set_lease_token(lease());
    const auto homed = ask(&CellStub::Home, request);
    ASSERT_TRUE(homed) << homed.error().message;
    v1::GiveUpLeaseRequest give_up;
    give_up.set_token(request.lease_token());
    ASSERT_TRUE(ask(&CellStub::GiveUpLease, give_up));
  }
  v1::MoveRequest move_to(double q_mm, const std::string& token) {
    v1::MoveRequest request;
    request.set_lease_token(token);
    auto& q = *request.add_coordinates();
    q.set_channel("q1_mm");
    q.set_value(q_mm);
    return request;
  }
};

TEST_F(CellServiceTest, TellsTheStatusWithItsValues) {
  const auto status = ask(&CellStub::GetStatus, v1::GetStatusRequest{});
  ASSERT_TRUE(status);
  EXPECT_EQ(status->cell_name(), "small");
  const auto value_of = [&](const std::string& wanted) {
    for (const auto& value : status->values())
      if (value.channel() == wanted) return value;
    return v1::LatestValue();
  };
  EXPECT_NEAR(value_of("t01_degC").value(), 20.1, 0.05);
  EXPECT_FALSE(status->has_run());
  EXPECT_FALSE(status->has_serving_model_id());
}

TEST(CellStatus, AProbeThatGaveNothingHasNoValue) {
  app::CellStatus status;
  status.values = {{{"t07", "degC"}, kMissing, {}, 0, true, "scanner"}};
  EXPECT_FALSE(rpc::status_from(status).values(0).has_value()) << "and not 0";
}

TEST_F(CellServiceTest, ListsDevicesWithTheirSoftLimits) {
  const auto devices = ask(&CellStub::ListDevices, v1::ListDevicesRequest{});
  ASSERT_TRUE(devices);
  ASSERT_EQ(devices->devices_size(), 4);
  EXPECT_EQ(devices->devices(0).link(), v1::Device::LINK_CONNECTED);
  EXPECT_DOUBLE_EQ(devices->devices(0).axes(0).max_mm(), 5);
}

TEST_F(CellServiceTest, GivesTheLeaseToOneClientAndNeverShowsItsToken) {
  const std::string token = lease();
  EXPECT_FALSE(token.empty());
  EXPECT_THAT(ask(&CellStub::TakeLease, v1::TakeLeaseRequest{}, "bob"),
              FailsWith(ErrorCode::permission_denied, "LEASE_HELD"));
  const auto status = ask(&CellStub::GetStatus, v1::GetStatusRequest{});
  EXPECT_EQ(status->lease().holder(), "ada");
  EXPECT_EQ(status->lease().token(), "");
  v1::GiveUpLeaseRequest give_up;
  give_up.set_token(token);
  EXPECT_TRUE(ask(&CellStub::GiveUpLease, give_up));
  EXPECT_TRUE(ask(&CellStub::TakeLease, v1::TakeLeaseRequest{}, "bob"));
}

TEST_F(CellServiceTest, RecordsWhoCalledAndFromWhere) {
  lease();
  const auto taken = cell.last_event("lease.taken");
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->who, "ada");
  EXPECT_TRUE(taken->from.starts_with("ipv4:127.0.0.1:")) << taken->from;
}

TEST_F(CellServiceTest, RefusesALeaseOfNegativeOrAbsurdDuration) {
  v1::TakeLeaseRequest request;
  request.mutable_lease_duration()->set_seconds(-1);
  EXPECT_THAT(ask(&CellStub::TakeLease, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_DURATION"));
  request.mutable_lease_duration()->set_seconds(INT64_MAX);
  EXPECT_THAT(ask(&CellStub::TakeLease, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_DURATION"));
}

TEST_F(CellServiceTest, MovesWithTheLeaseOnly) {
  EXPECT_THAT(ask(&CellStub::Move, move_to(0.25, "")),
              FailsWith(ErrorCode::permission_denied, "LEASE_REQUIRED"));
  const auto passing = cell.passing();
  home();
  const auto moved = ask(&CellStub::Move, move_to(0.25, lease()));
  EXPECT_TRUE(moved) << moved.error().message;
  EXPECT_NEAR(cell.on_executor([&] { return cell.world.to_mm - cell.world.reference_mm; }), 0.25,
              1e-3);
}

TEST_F(CellServiceTest, RefusesAMoveThatIsNotMeant) {
  const std::string token = lease();
  EXPECT_THAT(ask(&CellStub::Move, move_to(std::nan(""), token)),
              FailsWith(ErrorCode::invalid_argument, "NOT_FINITE"));
  EXPECT_THAT(ask(&CellStub::Move, move_to(99, token)),
              FailsWith(ErrorCode::out_of_range, "SOFT_LIMIT"));
  auto request = move_to(1, token);
  request.mutable_coordinates(0)->set_channel("q2_mm");
  EXPECT_THAT(ask(&CellStub::Move, request),
              FailsWith(ErrorCode::invalid_argument, "UNKNOWN_AXIS"));
  request.mutable_coordinates(0)->set_channel("q1");
  EXPECT_THAT(ask(&CellStub::Move, request), FailsWith(ErrorCode::invalid_argument, "BAD_CHANNEL"));
  request.clear_coordinates();
  EXPECT_THAT(ask(&CellStub::Move, request),
              FailsWith(ErrorCode::invalid_argument, "MISSING_COORDINATE"));
  request = move_to(1, token);
  *request.add_coordinates() = request.coordinates(0);
  EXPECT_THAT(ask(&CellStub::Move, request),
              FailsWith(ErrorCode::invalid_argument, "DUPLICATE_CHANNEL"));
  request = move_to(1, token);
  request.mutable_coordinates(0)->clear_value();
  EXPECT_THAT(ask(&CellStub::Move, request),
              FailsWith(ErrorCode::invalid_argument, "MISSING_VALUE"));
  for (int i = 0; i < 70; ++i) request.add_coordinates()->set_channel("q1_mm");
  EXPECT_THAT(ask(&CellStub::Move, request),
              FailsWith(ErrorCode::invalid_argument, "TOO_MANY_VALUES"));
  EXPECT_EQ(cell.on_executor([&] { return cell.world.moves; }), 0) << "the axis heard of none";
}

TEST_F(CellServiceTest, StopsWithoutALease) {
  const auto passing = cell.passing();  // a stop asks the axis twice
  EXPECT_TRUE(ask(&CellStub::StopAll, v1::StopAllRequest{}, "bob"));
  EXPECT_GE(cell.on_executor([&] { return cell.world.stops; }), 1);
  EXPECT_EQ(cell.last_event("stop")->who, "bob");
}

TEST_F(CellServiceTest, HomesAndTellsWhyNot) {
  const auto passing = cell.passing();
  home();
  EXPECT_EQ(cell.on_executor([&] { return cell.world.homes; }), 1);
  v1::HomeRequest request;
  ASSERT_TRUE(ask(&CellStub::TakeLease, v1::TakeLeaseRequest{}));
  request.set_lease_token("another");
  EXPECT_THAT(ask(&CellStub::Home, request), FailsWith(ErrorCode::permission_denied, "LEASE_HELD"));
}

TEST_F(CellServiceTest, SetsAStabiliserToAStatedTemperatureOnly) {
  const auto passing = cell.passing();  // the controller answers after a while
  v1::SetStabiliserRequest request;
  request.set_lease_token(lease());
  request.set_device_id("support");
  EXPECT_THAT(ask(&CellStub::SetStabiliser, request),
              FailsWith(ErrorCode::invalid_argument, "NOT_FINITE"));
  request.set_set_point_degc(20.5);
  EXPECT_TRUE(ask(&CellStub::SetStabiliser, request));
  EXPECT_EQ(cell.on_executor([&] { return cell.world.support_set_degc; }), 20.5);
}

TEST_F(CellServiceTest, ShowsAndSetsTheControlLoopOfAStabiliserWithARecord) {
  const auto passing = cell.passing();  // the controller answers after a while
  v1::GetStabiliserRequest shown;
  shown.set_device_id("laser-x");
  EXPECT_THAT(ask(&CellStub::GetStabiliser, shown),
              FailsWith(ErrorCode::not_found, "NO_STABILISER"));
  shown.set_device_id("support");
  const auto now = ask(&CellStub::GetStabiliser, shown);
  ASSERT_TRUE(now);
  EXPECT_EQ(now->tuning().heat_band_k(), 2);
  EXPECT_EQ(now->tuning().integral_duration().seconds(), 180);
  EXPECT_FALSE(now->declared().has_heat_band_k()) << "the cell file declares nothing";

  v1::TuneStabiliserRequest request;
  request.set_device_id("support");
  request.mutable_tuning()->set_heat_band_k(3.5);
  EXPECT_THAT(ask(&CellStub::TuneStabiliser, request),
              FailsWith(ErrorCode::permission_denied, "LEASE_REQUIRED"));
  request.set_lease_token(lease());
  const auto tuned = ask(&CellStub::TuneStabiliser, request);
  ASSERT_TRUE(tuned);
  EXPECT_EQ(tuned->before().heat_band_k(), 2);
  EXPECT_EQ(tuned->after().heat_band_k(), 3.5);
  EXPECT_EQ(tuned->after().cool_band_k(), 2) << "what is not given stays";
  EXPECT_EQ(ask(&CellStub::GetStabiliser, shown)->tuning().heat_band_k(), 3.5);
  const auto record = cell.last_event("stabiliser.tuned");
  ASSERT_TRUE(record);
  EXPECT_THAT(record->detail, testing::HasSubstr("3.5"));
}

TEST_F(CellServiceTest, ListsEventsByCursor) {
  EventId before;
  for (int i = 0; i < 5; ++i) {
    const EventId added = cell.add_event("device.lost");
    if (i == 2) before = added;
  }
  v1::ListEventsRequest request;
  request.set_after_event_id(before.value);
  const auto events = ask(&CellStub::ListEvents, request);
  ASSERT_TRUE(events);
  ASSERT_EQ(events->events_size(), 2);
  EXPECT_EQ(events->events(0).id(), before.value + 1);
  request.set_after_event_id(-1);
  EXPECT_THAT(ask(&CellStub::ListEvents, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_CURSOR"));
  request.set_after_event_id(0);
  request.set_limit(1001);
  EXPECT_THAT(ask(&CellStub::ListEvents, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_LIMIT"));
}

TEST_F(CellServiceTest, ANameIsCutAndFreedOfControlCharacters) {
  const auto passing = cell.passing();  // a stop asks the axis twice
  EXPECT_TRUE(ask(&CellStub::StopAll, v1::StopAllRequest{}, std::string(500, 'n')));
  EXPECT_EQ(cell.last_event("stop")->who, std::string(64, 'n'));
  Call call("");
  call.AddMetadata("driftwise-operator-bin", "J\xc3\xbcrg\n\xff");
  v1::TakeLeaseResponse response;
  EXPECT_TRUE(CellStub(channel).TakeLease(&call, {}, &response).ok());
  EXPECT_EQ(cell.last_event("lease.taken")->who, "J\xc3\xbcrg ?");
}

}  // namespace
}  // namespace driftwise::tests
