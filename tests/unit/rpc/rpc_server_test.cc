#include "server/rpc/server/rpc_server.h"

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/impl/codegen/proto_utils.h>

#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/data_service.grpc.pb.h"
#include "driftwise/v1/run_service.grpc.pb.h"
#include "server/rpc/server/connection_gate.h"
#include "tests/unit/rpc/rpc_fixture.h"

namespace driftwise::tests {
namespace {

class RpcServerTest : public RpcTest {
 protected:
  // Debian has no health.proto: HealthCheckRequest is {1: service}, the answer {1: status}, 1 =
  // SERVING, 2 = NOT_SERVING.
  int health_of(const std::string& service) {
    const std::string bytes =
        service.empty() ? "" : std::string("\x0a") + static_cast<char>(service.size()) + service;
    const grpc::Slice slice(bytes);
    grpc::ByteBuffer request(&slice, 1), response;
    Call call;
    grpc::CompletionQueue queue;
    grpc::GenericStub stub(channel);
    const auto rpc = stub.PrepareUnaryCall(&call, "/grpc.health.v1.Health/Check", request, &queue);
    rpc->StartCall();
    grpc::Status status;
    rpc->Finish(&response, &status, this);
    void* tag = nullptr;
    bool ok = false;
    queue.Next(&tag, &ok);
    if (!status.ok()) return -static_cast<int>(status.error_code());
    std::vector<grpc::Slice> slices;
    response.Dump(&slices);
    return slices.empty() || slices[0].size() < 2 ? 0 : slices[0].begin()[1];
  }
};

TEST_F(RpcServerTest, IsServingPerServiceOnlyWhenReady) {
  EXPECT_EQ(health_of(""), 1);
  EXPECT_EQ(health_of("driftwise.v1.RunService"), 1);
  server->ready(false);
  EXPECT_EQ(health_of(""), 2);
  EXPECT_EQ(health_of("driftwise.v1.TargetService"), 2);
  EXPECT_EQ(health_of("no.such.Service"), -grpc::StatusCode::NOT_FOUND);
}

TEST_F(RpcServerTest, ListensOnLoopbackOnly) {
  for (const char* listen : {"0.0.0.0:0", "192.168.1.4:0", "[::]:0", "example.org:0"})
    EXPECT_THAT(rpc::RpcServer::open(cell.services(), listen),
                FailsWith(ErrorCode::invalid_argument, "NOT_LOOPBACK"))
        << listen;
  for (const char* listen :
       {"", "127.0.0.1", "127.0.0.1:", "127.0.0.1:99999", "127.0.0.1:-1", "127.0.0.1:x", ":50051"})
    EXPECT_THAT(rpc::RpcServer::open(cell.services(), listen),
                FailsWith(ErrorCode::invalid_argument, "BAD_ADDRESS"))
        << listen;
}

TEST_F(RpcServerTest, SaysWhenThePortIsTaken) {
  EXPECT_THAT(rpc::RpcServer::open(cell.services(), server->address()),
              FailsWith(ErrorCode::unavailable, "ADDRESS_IN_USE"));
}

TEST_F(RpcServerTest, OpensBeforeTheComputerHasTheAddress) {
  // TEST-NET-1 (RFC 5737): no computer's address.
  const auto gate = rpc::ConnectionGate::open("192.0.2.1:0", nullptr);
  ASSERT_TRUE(gate) << gate.error().message;
  EXPECT_NE((*gate)->port(), 0);
}

TEST_F(RpcServerTest, RefusesARequestBeyondItsLimit) {
  v1::ImportDatasetRequest request;
  request.set_csv(std::string(34 << 20, 'x'));
  EXPECT_EQ(ask(&v1::DataService::Stub::ImportDataset, request).error().code,
            ErrorCode::resource_exhausted);
  request.set_csv(std::string((32 << 20) + 1, 'x'));
  EXPECT_THAT(ask(&v1::DataService::Stub::ImportDataset, request),
              FailsWith(ErrorCode::invalid_argument, "TOO_LONG"));
}

TEST_F(RpcServerTest, SurvivesBytesThatAreNoMessage) {
  const grpc::Slice slice(std::string(1000, '\xff'));
  grpc::ByteBuffer request(&slice, 1), response;
  Call call;
  grpc::CompletionQueue queue;
  grpc::GenericStub stub(channel);
  const auto rpc =
      stub.PrepareUnaryCall(&call, "/driftwise.v1.TargetService/ComputeTarget", request, &queue);
  rpc->StartCall();
  grpc::Status status;
  rpc->Finish(&response, &status, this);
  void* tag = nullptr;
  bool ok = false;
  queue.Next(&tag, &ok);
  EXPECT_FALSE(status.ok());
  EXPECT_EQ(health_of(""), 1);
}

// The page's way: what a client over TCP is answered is answered there too.
TEST_F(RpcServerTest, AnswersOfManyMegabytesPassTheInProcessChannel) {
  constexpr int kPoints = 100, kChannels = 2400;
  const RunId run = cell.add_run();
  PointRecord point;
  for (int i = 0; i < kChannels; ++i)
    point.values.push_back({"channel_" + std::to_string(i) + "_mm", 1.2345});
  cell.add_points(run, std::vector<PointRecord>(kPoints, point));
  v1::ListPointsRequest request;
  request.set_run_id(run.value);
  v1::ListPointsResponse response;
  Call call;
  const auto status =
      v1::RunService::Stub(server->in_process_channel()).ListPoints(&call, request, &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(response.points_size(), kPoints);
  EXPECT_GT(response.ByteSizeLong(), std::size_t{5 << 20});
}

TEST_F(RpcServerTest, OffersReflectionAndAnInProcessChannel) {
  const auto inside = server->in_process_channel();
  Call call;
  v1::ListDevicesResponse response;
  EXPECT_TRUE(v1::CellService::Stub(inside).ListDevices(&call, {}, &response).ok());
  grpc::Status status;
  Call other;
  grpc::CompletionQueue queue;
  grpc::GenericStub stub(channel);
  const auto stream = stub.PrepareCall(
      &other, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", &queue);
  void* tag = nullptr;
  bool ok = false;
  stream->StartCall(this);
  queue.Next(&tag, &ok);
  const grpc::Slice list_services(std::string("\x3a\x00", 2));  // {7: list_services ""}
  stream->Write(grpc::ByteBuffer(&list_services, 1), this);
  queue.Next(&tag, &ok);
  grpc::ByteBuffer answer;
  stream->Read(&answer, this);
  queue.Next(&tag, &ok);
  ASSERT_TRUE(ok);
  std::vector<grpc::Slice> slices;
  answer.Dump(&slices);
  std::string text;
  for (const auto& slice : slices) text.append(slice.begin(), slice.end());
  EXPECT_THAT(text, testing::HasSubstr("driftwise.v1.ModelService"));
  other.TryCancel();
  stream->Finish(&status, this);
  queue.Next(&tag, &ok);
}

}  // namespace
}  // namespace driftwise::tests
