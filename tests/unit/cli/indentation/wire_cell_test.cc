// The end of an indentation whose cell sends no reading any more.

#include "clients/cli/commands/indentation/wire_cell.h"

#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <thread>

#include "driftwise/v1/cell_service.grpc.pb.h"

namespace driftwise::cli {
namespace {

using std::chrono::milliseconds;

// All of its devices are silent: the stream of readings stands and brings nothing.
class SilentCell final : public v1::CellService::Service {
 public:
  SilentCell() {
    int port = 0;
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
    address_ = "127.0.0.1:" + std::to_string(port);
  }
  ~SilentCell() override { server_->Shutdown(std::chrono::system_clock::now()); }
  const std::string& address() const { return address_; }

  grpc::Status GetStatus(grpc::ServerContext*, const v1::GetStatusRequest*,
                         v1::GetStatusResponse* response) override {
    response->set_speed(1);
    return grpc::Status::OK;
  }
  grpc::Status TakeLease(grpc::ServerContext*, const v1::TakeLeaseRequest*,
                         v1::TakeLeaseResponse* response) override {
    response->mutable_lease()->set_token("token");
    return grpc::Status::OK;
  }
  grpc::Status GiveUpLease(grpc::ServerContext*, const v1::GiveUpLeaseRequest* request,
                           v1::GiveUpLeaseResponse*) override {
    is_given_up = request->token() == "token";
    return grpc::Status::OK;
  }
  grpc::Status WatchReadings(grpc::ServerContext* context, const v1::WatchReadingsRequest*,
                             grpc::ServerWriter<v1::WatchReadingsResponse>*) override {
    is_followed.set_value();
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!context->IsCancelled() && std::chrono::steady_clock::now() < limit)
      std::this_thread::sleep_for(milliseconds(5));
    is_left = context->IsCancelled();
    ended.set_value();
    return grpc::Status::OK;
  }

  std::promise<void> is_followed, ended;
  std::atomic<bool> is_left{false}, is_given_up{false};

 private:
  std::string address_;
  std::unique_ptr<grpc::Server> server_;
};

TEST(WireCell, LeavesASilentStreamAndGivesItsLeaseUp) {
  SilentCell daemon;
  Way way;
  way.address = daemon.address();
  const Connection connection(way, "ada", 0, nullptr);
  const formats::IndentationFile file;
  {
    const WireCell cell(connection, file, {});
    daemon.is_followed.get_future().wait();
  }
  daemon.ended.get_future().wait();
  EXPECT_TRUE(daemon.is_left) << "the stream was waited for until the daemon ended it";
  EXPECT_TRUE(daemon.is_given_up);
}

}  // namespace
}  // namespace driftwise::cli
