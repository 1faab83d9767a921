// What halts the robot, asked for while no daemon answers, or one that refuses.

#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <atomic>
#include <filesystem>

#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/record_service.grpc.pb.h"
#include "server/formats/text/kept_stop.h"
#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

using testing::AllOf;
using testing::Not;

class HaltingWithoutADaemon : public CliTest {
 protected:
  // A daemon that was killed leaves its driftwised.json.
  void SetUp() override {
    CliTest::SetUp();
    file("driftwised.json", "{\"grpc\": \"" + server->address() + "\"}");
    server.reset();
    environment.erase("DRIFTWISE_SERVER");
  }
  std::string kept_path() const { return folder.path() + "/" + formats::kKeptStopFile; }
  bool is_kept() const { return std::filesystem::exists(kept_path()); }
};

TEST_F(HaltingWithoutADaemon, NamesTheEmergencySwitchAndKeepsTheStopForTheNextStart) {
  const auto outcome = run({"stop"});
  EXPECT_EQ(outcome.exit, 4);
  EXPECT_THAT(outcome.err,
              AllOf(HasSubstr("NOT STOPPED: use the emergency switch. cannot reach the daemon at "),
                    HasSubstr("kept in " + kept_path()), HasSubstr("wait for a person"),
                    Not(HasSubstr("Start it"))));
  ASSERT_TRUE(is_kept());
  std::ifstream kept(kept_path());
  const std::string text{std::istreambuf_iterator<char>(kept), {}};
  EXPECT_EQ(formats::read_kept_stop(text).who, "ada");
}

TEST_F(HaltingWithoutADaemon, CountsForAPauseAndAnAbortToo) {
  EXPECT_THAT(run({"run", "abort", "3"}).err, HasSubstr("NOT ABORTED: use the emergency switch"));
  EXPECT_TRUE(is_kept());
  std::filesystem::remove(kept_path());
  EXPECT_THAT(run({"run", "pause", "3"}).err, HasSubstr("NOT PAUSED: use the emergency switch"));
  EXPECT_TRUE(is_kept());
}

TEST_F(HaltingWithoutADaemon, SaysThatAStartGoesOnWhereTheCellIsNotKnown) {
  const auto goes_on = AllOf(HasSubstr("NOT STOPPED: use the emergency switch"),
                             HasSubstr("could not be kept"), HasSubstr("goes on with a run"),
                             HasSubstr("let none start"), Not(HasSubstr("Start it")));
  const auto another = run({"stop", "--server", "127.0.0.1:1"});
  EXPECT_EQ(another.exit, 4);
  EXPECT_THAT(another.err, goes_on);
  EXPECT_FALSE(is_kept()) << "the stop of another cell";
  std::filesystem::remove(folder.path() + "/driftwised.json");
  EXPECT_THAT(run({"stop", "--server", "127.0.0.1:1"}).err, goes_on);
  EXPECT_FALSE(is_kept());
}

TEST_F(HaltingWithoutADaemon, SaysThatAStartGoesOnWhereTheFolderCannotBeWritten) {
  std::filesystem::create_directory(kept_path());
  EXPECT_THAT(run({"stop"}).err, AllOf(HasSubstr("could not be kept: cannot write " + kept_path()),
                                       HasSubstr("goes on with a run")));
}

TEST_F(HaltingWithoutADaemon, KeepsNothingForWhatHaltsNothing) {
  EXPECT_THAT(run({"status"}).err, AllOf(HasSubstr("Start it"), Not(HasSubstr("NOT "))));
  EXPECT_FALSE(is_kept());
}

class HaltingThatIsRefused : public CliTest {
 protected:
  void SetUp() override {
    CliTest::SetUp();
    file("driftwised.json", "{\"grpc\": \"" + server->address() + "\"}");
  }
  bool is_kept() const { return std::filesystem::exists(folder.path() + "/driftwised.stop"); }
};

TEST_F(HaltingThatIsRefused, NamesTheEmergencySwitchWhateverTheDaemonSays) {
  const auto abort = run({"run", "abort", "99"});
  EXPECT_EQ(abort.exit, 3);
  EXPECT_THAT(abort.err, HasSubstr("driftwise: NOT ABORTED: use the emergency switch. "));
  const auto pause = run({"run", "pause", "99"});
  EXPECT_EQ(pause.exit, 3);
  EXPECT_THAT(pause.err, HasSubstr("driftwise: NOT PAUSED: use the emergency switch. "));
  EXPECT_FALSE(is_kept()) << "what a daemon refused is not asked of its next start";
}

TEST_F(HaltingThatIsRefused, NamesItWhereTheWayToTheDaemonCannotBeUsed) {
  const auto stop = run({"stop", "--tls-ca", folder.path() + "/none.pem"});
  EXPECT_EQ(stop.exit, 3);
  EXPECT_THAT(stop.err, AllOf(HasSubstr("driftwise: NOT STOPPED: use the emergency switch. "),
                              HasSubstr("none.pem")));
}

TEST_F(HaltingThatIsRefused, SaysThatAnotherProgramIsNoDaemonOfThisVersion) {
  v1::RecordService::Service other;
  int port = 0;
  grpc::ServerBuilder builder;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterService(&other);
  const auto program = builder.BuildAndStart();
  environment["DRIFTWISE_SERVER"] = "127.0.0.1:" + std::to_string(port);
  const std::string is_none =
      "the program at 127.0.0.1:" + std::to_string(port) + " is no daemon of this version";
  const auto stop = run({"stop"});
  EXPECT_EQ(stop.exit, 5);
  EXPECT_THAT(stop.err, HasSubstr("NOT STOPPED: use the emergency switch. " + is_none));
  EXPECT_THAT(run({"status"}).err,
              AllOf(HasSubstr("driftwise: " + is_none), HasSubstr("--server")));
}

// A daemon whose axis is slowing down while it answers, as of a long move.
class SlowingDown : public v1::CellService::Service {
 public:
  explicit SlowingDown(int looks) : looks_(looks) {}
  grpc::Status StopAll(grpc::ServerContext*, const v1::StopAllRequest*,
                       v1::StopAllResponse* answer) override {
    answer->set_message("not confirmed: use the emergency switch");
    answer->add_pending()->set_device_id("axis");
    return grpc::Status::OK;
  }
  grpc::Status GetStatus(grpc::ServerContext*, const v1::GetStatusRequest*,
                         v1::GetStatusResponse* status) override {
    if (looks_-- > 0) status->add_pending_stops()->set_device_id("axis");
    return grpc::Status::OK;
  }

 private:
  std::atomic<int> looks_;
};

class HaltingThatTakesAWhile : public CliTest {
 protected:
  Outcome stop_of_an_axis_that_rests_after(int looks) {
    SlowingDown daemon(looks);
    int port = 0;
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(&daemon);
    const auto running = builder.BuildAndStart();
    environment["DRIFTWISE_SERVER"] = "127.0.0.1:" + std::to_string(port);
    return run({"stop"});
  }
};

TEST_F(HaltingThatTakesAWhile, IsSaidAtOnceAndAgainWhenTheAxisRests) {
  const auto outcome = stop_of_an_axis_that_rests_after(2);
  EXPECT_EQ(outcome.exit, 0);
  EXPECT_THAT(outcome.err, HasSubstr("not confirmed: use the emergency switch"));
  EXPECT_THAT(outcome.out, HasSubstr("stopped: every controller reports no motion now"));
}

TEST_F(HaltingThatTakesAWhile, IsNoSuccessWhileTheAxisMoves) {
  const auto outcome = stop_of_an_axis_that_rests_after(1000000);
  EXPECT_EQ(outcome.exit, 5);
  EXPECT_THAT(outcome.err, HasSubstr("not confirmed: use the emergency switch"));
  EXPECT_THAT(outcome.out, testing::IsEmpty());
}

}  // namespace
}  // namespace driftwise::tests
