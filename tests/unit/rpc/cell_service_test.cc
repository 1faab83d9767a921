#include "driftwise/v1/cell_service.grpc.pb.h"
#include "tests/unit/rpc/rpc_fixture.h"

namespace driftwise::tests {
namespace {

using CellStub = v1::CellService::Stub;

class CellServiceTest : public RpcTest {
 protected:
  std::string lease() { return ask(&CellStub::TakeLease, v1::TakeLeaseRequest{})->lease().token(); }
  v1::MoveRequest move_to(double q_mm, const std::string& token) {
    v1::MoveRequest request;
    request.set_lease_token(token);
    auto& q = *request.add_coordinates();
    q.set_channel("q1_mm");
    q.set_value(q_mm);
    return request;
  }
};

TEST_F(CellServiceTest, TellsTheStatusWithValuesAndWhatIsMissing) {
  const auto status = ask(&CellStub::GetStatus, v1::GetStatusRequest{});
  ASSERT_TRUE(status);
  EXPECT_EQ(status->cell_name(), "linear-axis");
  ASSERT_EQ(status->values_size(), 2);
  EXPECT_EQ(status->values(0).channel(), "t07_degC");
  EXPECT_DOUBLE_EQ(status->values(0).value(), 20.5123);
  EXPECT_FALSE(status->values(1).has_value()) << "a probe that gave nothing has no value, not 0";
  EXPECT_FALSE(status->has_run());
  EXPECT_FALSE(status->has_serving_model_id());
}

TEST_F(CellServiceTest, ListsDevicesWithTheirSoftLimits) {
  const auto devices = ask(&CellStub::ListDevices, v1::ListDevicesRequest{});
  ASSERT_TRUE(devices);
  ASSERT_EQ(devices->devices_size(), 1);
  EXPECT_EQ(devices->devices(0).link(), v1::Device::LINK_CONNECTED);
  EXPECT_DOUBLE_EQ(devices->devices(0).axes(0).max_mm(), 4.5);
}

TEST_F(CellServiceTest, GivesTheLeaseToOneClientAndNeverShowsItsToken) {
  EXPECT_EQ(lease(), "token-ada");
  EXPECT_THAT(ask(&CellStub::TakeLease, v1::TakeLeaseRequest{}, "bob"),
              FailsWith(ErrorCode::permission_denied, "LEASE_HELD"));
  const auto status = ask(&CellStub::GetStatus, v1::GetStatusRequest{});
  EXPECT_EQ(status->lease().holder(), "ada");
  EXPECT_EQ(status->lease().token(), "");
  v1::GiveUpLeaseRequest give_up;
  give_up.set_token("token-ada");
  EXPECT_TRUE(ask(&CellStub::GiveUpLease, give_up));
  EXPECT_TRUE(ask(&CellStub::TakeLease, v1::TakeLeaseRequest{}, "bob"));
}

TEST_F(CellServiceTest, RecordsWhoCalledAndFromWhere) {
  lease();
  EXPECT_EQ(cell.on_executor([&] { return cell.last_caller.name; }), "ada");
  EXPECT_TRUE(
      cell.on_executor([&] { return cell.last_caller.peer; }).starts_with("ipv4:127.0.0.1:"));
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
  EXPECT_TRUE(ask(&CellStub::Move, move_to(0.25, lease())));
  EXPECT_EQ(cell.on_executor([&] { return cell.calls; }),
            std::vector<std::string>{"move_to ada q=0.250000"});
}

TEST_F(CellServiceTest, RefusesAMoveThatIsNotMeant) {
  const std::string token = lease();
  EXPECT_THAT(ask(&CellStub::Move, move_to(std::nan(""), token)),
              FailsWith(ErrorCode::invalid_argument, "NOT_FINITE"));
  EXPECT_THAT(ask(&CellStub::Move, move_to(99, token)),
              FailsWith(ErrorCode::out_of_range, "OUTSIDE_LIMITS"));
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
  EXPECT_EQ(cell.on_executor([&] { return cell.calls.size(); }), 0U)
      << "the cell heard of none of them";
}

TEST_F(CellServiceTest, StopsWithoutALease) {
  EXPECT_TRUE(ask(&CellStub::StopAll, v1::StopAllRequest{}, "bob"));
  EXPECT_EQ(cell.on_executor([&] { return cell.calls; }), std::vector<std::string>{"stop_all bob"});
}

TEST_F(CellServiceTest, HomesAndTellsWhyNot) {
  v1::HomeRequest request;
  request.set_lease_token(lease());
  EXPECT_TRUE(ask(&CellStub::Home, request));
  cell.on_executor([&] {
    cell.fail_next = Error{ErrorCode::aborted, "STOPPED", "stopped by bob"};
  });
  EXPECT_THAT(ask(&CellStub::Home, request), FailsWith(ErrorCode::aborted, "STOPPED"));
}

TEST_F(CellServiceTest, SetsAStabiliserToAStatedTemperatureOnly) {
  v1::SetStabiliserRequest request;
  request.set_lease_token(lease());
  request.set_device_id("support");
  EXPECT_THAT(ask(&CellStub::SetStabiliser, request),
              FailsWith(ErrorCode::invalid_argument, "NOT_FINITE"));
  request.set_set_point_degc(20.5);
  EXPECT_TRUE(ask(&CellStub::SetStabiliser, request));
  EXPECT_EQ(cell.on_executor([&] { return cell.calls; }),
            std::vector<std::string>{"set_stabiliser support 20.500000"});
}

TEST_F(CellServiceTest, ListsEventsByCursor) {
  cell.on_executor([&] {
    for (int i = 0; i < 5; ++i) cell.add_event("device.lost");
  });
  v1::ListEventsRequest request;
  request.set_after_event_id(3);
  const auto events = ask(&CellStub::ListEvents, request);
  ASSERT_TRUE(events);
  ASSERT_EQ(events->events_size(), 2);
  EXPECT_EQ(events->events(0).id(), 4);
  request.set_after_event_id(-1);
  EXPECT_THAT(ask(&CellStub::ListEvents, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_CURSOR"));
  request.set_after_event_id(0);
  request.set_limit(1001);
  EXPECT_THAT(ask(&CellStub::ListEvents, request),
              FailsWith(ErrorCode::invalid_argument, "BAD_LIMIT"));
}

TEST_F(CellServiceTest, ANameIsCutAndFreedOfControlCharacters) {
  EXPECT_TRUE(ask(&CellStub::StopAll, v1::StopAllRequest{}, std::string(500, 'n')));
  EXPECT_EQ(cell.on_executor([&] { return cell.calls.at(0); }), "stop_all " + std::string(64, 'n'));
  Call call("");
  call.AddMetadata("driftwise-operator-bin", "J\xc3\xbcrg\n\xff");
  v1::StopAllResponse response;
  EXPECT_TRUE(CellStub(channel).StopAll(&call, {}, &response).ok());
  EXPECT_EQ(cell.on_executor([&] { return cell.calls.at(1); }), "stop_all J\xc3\xbcrg ?");
}

}  // namespace
}  // namespace driftwise::tests
