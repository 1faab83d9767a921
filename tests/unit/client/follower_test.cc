// A follower whose daemon has fallen silent: the connection stands, and nothing comes.

#include <google/protobuf/util/time_util.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <mutex>
#include <string>
#include <vector>

#include "clients/cpp/include/driftwise/client.h"
#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/target_service.grpc.pb.h"

namespace driftwise::client {
namespace {

using google::protobuf::util::TimeUtil;
using std::chrono::milliseconds;

// Sends one target in each stream, whose clock is a day from ours, and then nothing until the
// stream is ended. Stops nothing: gRPC's answer where it ends meanwhile.
class SilentDaemon final : public v1::TargetService::Service {
 public:
  explicit SilentDaemon(std::int64_t lifetime_ms) : lifetime_ms_(lifetime_ms) {
    int port = 0;
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(this);
    builder.RegisterService(&ending_);
    server_ = builder.BuildAndStart();
    address_ = "127.0.0.1:" + std::to_string(port);
  }
  ~SilentDaemon() override {
    silence_.set_value();
    server_->Shutdown(std::chrono::system_clock::now());
  }
  const std::string& address() const { return address_; }

  // Wall time between two answers, as the streams so far asked for it.
  std::vector<std::int64_t> intervals_ms() const {
    const std::lock_guard lock(mutex_);
    return intervals_ms_;
  }
  std::string authorization() const {  // of the last question
    const std::lock_guard lock(mutex_);
    return authorization_;
  }

  grpc::Status ComputeTarget(grpc::ServerContext* context, const v1::ComputeTargetRequest*,
                             v1::ComputeTargetResponse*) override {
    const auto found = context->client_metadata().find("authorization");
    const std::lock_guard lock(mutex_);
    if (found != context->client_metadata().end())
      authorization_.assign(found->second.data(), found->second.size());
    return grpc::Status::OK;
  }

  grpc::Status WatchTargets(grpc::ServerContext*, const v1::WatchTargetsRequest* request,
                            grpc::ServerWriter<v1::WatchTargetsResponse>* writer) override {
    {
      const std::lock_guard lock(mutex_);
      intervals_ms_.push_back(TimeUtil::DurationToMilliseconds(request->min_interval_duration()));
    }
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
  class Ending final : public v1::CellService::Service {
    grpc::Status StopAll(grpc::ServerContext*, const v1::StopAllRequest*,
                         v1::StopAllResponse*) override {
      return {grpc::StatusCode::CANCELLED, "CANCELLED"};
    }
  };

  const std::int64_t lifetime_ms_;
  Ending ending_;
  mutable std::mutex mutex_;
  std::vector<std::int64_t> intervals_ms_;
  std::string authorization_;
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

// The daemon holds its next answer back for an hour: no target may stand for so long. The interval
// becomes half of a target's life.
TEST(TargetFollower, KeepsNoTargetBeyondItsLifeForTheSakeOfAnInterval) {
  SilentDaemon daemon(100);
  Client client(daemon.address(), "press");
  const auto follower = client.follow({{"x_mm", 1.5}}, std::chrono::hours(1));
  EXPECT_EQ(reason_after(follower, "a target"), "EXPIRED");
  EXPECT_EQ(daemon.intervals_ms(), (std::vector<std::int64_t>{3'600'000, 50}));
}

TEST(Client, SaysThatNothingWasStoppedWhenTheDaemonEndsMeanwhile) {
  SilentDaemon daemon(100);
  const auto stopped = Client(daemon.address(), "press").stop_all(std::chrono::seconds(20));
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().reason, "NO_DAEMON");
  EXPECT_EQ(stopped.error().message.find("NOT STOPPED: use the emergency switch"), 0U);
}

Client with_token(const std::string& address, const std::string& token) {
  Credentials credentials;
  credentials.token = token;
  return Client(address, "press", credentials);
}

TEST(Client, TakesATokenAsItsFileHoldsIt) {
  SilentDaemon daemon(100);
  const auto client = with_token(daemon.address(), "dwt_secret\r\n");
  ASSERT_TRUE(client.target({{"x_mm", 1.5}}, std::chrono::seconds(20)));
  EXPECT_EQ(daemon.authorization(), "Bearer dwt_secret");
}

// gRPC itself ends the process over such a header.
TEST(Client, RefusesATokenThatNoHeaderHolds) {
  SilentDaemon daemon(100);
  for (const char* token : {"dwt_one\ndwt_two", "dwt one", "dwt_\xC3\xA9"}) {
    const auto client = with_token(daemon.address(), token);
    const auto asked = client.target({{"x_mm", 1.5}}, std::chrono::seconds(20));
    ASSERT_FALSE(asked) << token;
    EXPECT_EQ(asked.error().reason, "BAD_CREDENTIALS");
    EXPECT_EQ(asked.error().message.find("dwt"), std::string::npos) << "the token is a secret";
    EXPECT_EQ(client.stop_all().error().message.find("NOT STOPPED"), 0U);
    EXPECT_EQ(reason_after(client.follow({{"x_mm", 1.5}}), ""), "BAD_CREDENTIALS");
  }
}

}  // namespace
}  // namespace driftwise::client
