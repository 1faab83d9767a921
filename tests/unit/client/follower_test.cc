// A follower whose daemon has fallen silent: the connection stands, and nothing comes.

#include <google/protobuf/util/time_util.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <string>

#include "clients/cpp/include/driftwise/client.h"
#include "driftwise/v1/target_service.grpc.pb.h"

namespace driftwise::client {
namespace {

using google::protobuf::util::TimeUtil;
using std::chrono::milliseconds;

// Sends one target, whose clock is a day from ours, and then nothing until the stream is ended.
class SilentDaemon final : public v1::TargetService::Service {
 public:
  explicit SilentDaemon(std::int64_t lifetime_ms) : lifetime_ms_(lifetime_ms) {
    int port = 0;
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
    address_ = "127.0.0.1:" + std::to_string(port);
  }
  ~SilentDaemon() override {
    silence_.set_value();
    server_->Shutdown(std::chrono::system_clock::now());
  }
  const std::string& address() const { return address_; }

  grpc::Status WatchTargets(grpc::ServerContext*, const v1::WatchTargetsRequest*,
                            grpc::ServerWriter<v1::WatchTargetsResponse>* writer) override {
    v1::WatchTargetsResponse response;
    auto& target = *response.mutable_target();
    const auto now = TimeUtil::GetCurrentTime() - TimeUtil::HoursToDuration(24);
    *target.mutable_conditions_time() = now;
    *target.mutable_valid_until_time() = now + TimeUtil::MillisecondsToDuration(lifetime_ms_);
    target.set_model_id(7);
    writer->Write(response);
    silent_.wait();
    return grpc::Status::OK;
  }

 private:
  const std::int64_t lifetime_ms_;
  std::promise<void> silence_;
  std::shared_future<void> silent_{silence_.get_future()};
  std::unique_ptr<grpc::Server> server_;
  std::string address_;
};

// What latest() says, once it says something else than NOT_YET and than `not_yet`.
std::string reason_after(const TargetFollower& follower, const std::string& not_yet) {
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  std::string reason = "NOT_YET";
  while ((reason == "NOT_YET" || reason == not_yet) && std::chrono::steady_clock::now() < limit) {
    follower.wait(follower.sequence(), milliseconds(10));
    const auto latest = follower.latest();
    reason = latest ? "a target" : latest.error().reason;
  }
  return reason;
}

TEST(TargetFollower, SaysThatATargetExpiredWhenTheDaemonIsSilent) {
  SilentDaemon daemon(100);
  Client client(daemon.address(), "press");
  const auto follower = client.follow({{"x_mm", 1.5}});
  EXPECT_EQ(reason_after(follower, "a target"), "EXPIRED");
  const auto sequence = follower.sequence();
  EXPECT_EQ(follower.wait(sequence, milliseconds(0)), sequence) << "no news came";
}

TEST(TargetFollower, KeepsATargetForItsLifetimeWhateverTheClocksSay) {
  SilentDaemon daemon(3'600'000);
  Client client(daemon.address(), "press");
  const auto follower = client.follow({{"x_mm", 1.5}});
  EXPECT_EQ(reason_after(follower, ""), "a target");
  EXPECT_EQ(follower.latest()->model_id, 7);
}

// Its flag says that it was expired when it came.
TEST(TargetFollower, ShowsATargetThatCameExpired) {
  SilentDaemon daemon(-1);
  Client client(daemon.address(), "press");
  EXPECT_EQ(reason_after(client.follow({{"x_mm", 1.5}}), ""), "a target");
}

}  // namespace
}  // namespace driftwise::client
