#include "server/line/target_line_server.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <future>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/compensation/snapshot_builder.h"
#include "tests/support/manual_clock.h"
#include "tests/support/process.h"
#include "tests/unit/compensation/models.h"
#include "tests/unit/line/line_client.h"
#include "tests/unit/plans/two_robots.h"

namespace driftwise::line {
namespace {

using Client = tests::LineClient;

compensation::Snapshot snapshot_of(ModelId id) {
  auto builder = std::move(*compensation::SnapshotBuilder::create(compensation::axis_model(), id,
                                                                  compensation::axis_cell()));
  builder.keep_model_datum();
  const ChannelValue t07{"t07_degC", 21};
  builder.observe(std::span(&t07, 1), tests::kTestEpoch);
  return builder.build(tests::kTestEpoch);
}

class TargetLine : public testing::Test {
 protected:
  TargetLine() : work_(asio::make_work_guard(context_)), thread_([this] { context_.run(); }) {
    server_ = std::move(*TargetLineServer::start(parts(), {"127.0.0.1:0"}));
  }
  ~TargetLine() override {
    on_executor([this] { server_.reset(); });
    work_.reset();
    thread_.join();
  }
  void on_executor(std::function<void()> work) {
    std::promise<void> done;
    asio::post(context_, [&] {
      work();
      done.set_value();
    });
    done.get_future().wait();
  }
  LineParts parts() {
    return {
        context_.get_executor(), context_.get_executor(), board_, clock_, *access_, &joint_board_};
  }
  plans::JointBoard joint_board_;
  asio::io_context context_;
  tests::ManualClock clock_;
  compensation::SnapshotBoard board_;
  const tests::TemporaryFolder folder_;
  std::unique_ptr<access::Access> access_ = *access::Access::open({}, folder_.path());
  std::unique_ptr<TargetLineServer> server_;
  asio::executor_work_guard<asio::io_context::executor_type> work_;
  std::thread thread_;
};

TEST_F(TargetLine, AnswersJointTargetsFromTheServingPlan) {
  Client client(server_->address());
  EXPECT_TRUE(client.ask("JOINT z_mm=1").starts_with("ERR NO_PLAN "));
  auto builder = *plans::JointBuilder::create(plans::joint_plan(), PlanId{7}, plans::joint_models(),
                                              plans::two_robot_cell());
  builder.anchor({}, [](ModelId) { return true; });
  ASSERT_TRUE(joint_board_.publish(builder.build(tests::kTestEpoch)));
  const auto answer =
      client.ask("JOINT x_mm=1 y_mm=0 z_mm=0 rx_arcsec=0 ry_arcsec=0 ma.z_mm=3 u=1");
  EXPECT_TRUE(answer.starts_with("OK mn.q1_mm=")) << answer;
  EXPECT_NE(answer.find(" plan=7 flags=MISSING_TEMPERATURE(t09_degC),"), std::string::npos)
      << answer;
}

TEST_F(TargetLine, AnswersEveryLineFromTheNewestSnapshot) {
  Client client(server_->address());
  EXPECT_TRUE(client.ask("TARGET x_mm=1").starts_with("ERR NO_MODEL "));
  ASSERT_TRUE(board_.publish(snapshot_of(ModelId{3})));
  EXPECT_EQ(client.ask("TARGET x_mm=1"),
            "OK q1_mm=3.5252 valid_until=2026-11-21T08:00:10Z model=3 flags=-");
  ASSERT_TRUE(board_.publish(snapshot_of(ModelId{4})));
  EXPECT_TRUE(client.ask("TARGET x_mm=1\r").ends_with("model=4 flags=-"));
}

// Three joints, far from where they are to be near to: the nearest solution has to be searched for.
compensation::Snapshot arm_snapshot() {
  KinematicsDescription arm;
  arm.kind = "serial-arm";
  arm.links = {{{"q1", "deg"}, 0, 300, 0, 90, 0},
               {{"q2", "deg"}, 0, 0, 500, 0, 0},
               {{"q3", "deg"}, 0, 0, 400, 0, 0}};
  calibration::Model model;
  model.geometry = calibration::Geometry{arm, {}, {}};
  auto builder =
      std::move(*compensation::SnapshotBuilder::create(model, ModelId{5}, CellDescription{}));
  return builder.build(tests::kTestEpoch);
}
constexpr const char* kSearched =
    "TARGET x_mm=500 y_mm=200 z_mm=400 near_q1_deg=170 near_q2_deg=-100 near_q3_deg=100\n";

// A background thread that does nothing until it is asked to.
class SearchingLine : public TargetLine {
 protected:
  SearchingLine() {
    on_executor([this] {
      auto apart = parts();
      apart.background = background_.get_executor();
      server_ = std::move(*TargetLineServer::start(apart, {"127.0.0.1:0"}));
    });
    if (!board_.publish(arm_snapshot())) throw std::runtime_error("no snapshot");
  }
  ~SearchingLine() override {
    on_executor([this] { server_.reset(); });
    search();
  }
  void search() {
    background_.restart();
    background_.run();
  }
  asio::io_context background_;
};

TEST_F(SearchingLine, KeepsTheExecutorFreeAndTheOrderOfAConnectionWhileItSearches) {
  Client searching(server_->address()), other(server_->address());
  searching.send(std::string(kSearched) + "MOVE\n");
  EXPECT_TRUE(other.ask("TARGET x_mm=0").starts_with("ERR MISSING_COORDINATE "));
  EXPECT_TRUE(other.ask("TARGET x_mm=5000 y_mm=0 z_mm=0 near_q1_deg=0 near_q2_deg=0 near_q3_deg=0")
                  .starts_with("ERR NO_POSE "));
  auto answers = std::async(std::launch::async, [&] {
    const auto first = searching.line();
    return std::pair(first, searching.line());
  });
  while (answers.wait_for(std::chrono::seconds(0)) != std::future_status::ready) search();
  const auto [first, second] = answers.get();
  EXPECT_TRUE(first.starts_with("OK q1_deg=")) << first;
  EXPECT_TRUE(second.starts_with("ERR UNKNOWN_VERB ")) << second;
}

TEST_F(SearchingLine, RefusesTheNinthSearchThatWouldWait) {
  std::vector<std::unique_ptr<Client>> clients;
  std::vector<std::future<std::string>> answers;
  for (int i = 0; i < 12; ++i) {
    clients.push_back(std::make_unique<Client>(server_->address()));
    answers.push_back(std::async(std::launch::async, [client = clients.back().get()] {
      client->send(kSearched);
      return client->line();
    }));
  }
  const auto is_ready = [](const std::future<std::string>& answer) {
    return answer.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  };
  while (std::ranges::count_if(answers, is_ready) < 4) std::this_thread::yield();
  std::vector<std::string> refused, answered;
  for (auto& answer : answers)
    if (is_ready(answer)) refused.push_back(answer.get());
  for (auto& answer : answers) {
    while (answer.valid() && !is_ready(answer)) search();
    if (answer.valid()) answered.push_back(answer.get());
  }
  ASSERT_EQ(refused.size(), 4u);
  for (const auto& one : refused)
    EXPECT_TRUE(one.starts_with("ERR BUSY 8 searches of an arm's joints are waiting")) << one;
  for (const auto& one : answered) EXPECT_TRUE(one.starts_with("OK q1_deg=")) << one;
  Client later(server_->address());
  auto again = std::async(std::launch::async, [&] {
    later.send(kSearched);
    return later.line();
  });
  while (!is_ready(again)) search();
  EXPECT_TRUE(again.get().starts_with("OK q1_deg="));
}

TEST_F(TargetLine, GoesOnAfterAMistake) {
  ASSERT_TRUE(board_.publish(snapshot_of(ModelId{3})));
  Client client(server_->address());
  EXPECT_TRUE(client.ask("MOVE x_mm=1").starts_with("ERR UNKNOWN_VERB "));
  EXPECT_TRUE(client.ask("TARGET x_mm=1").starts_with("OK "));
}

TEST_F(TargetLine, AnswersLinesThatArriveInPiecesOrTogether) {
  ASSERT_TRUE(board_.publish(snapshot_of(ModelId{3})));
  Client client(server_->address());
  for (const char c : std::string_view("TARGET x_mm=0\n")) client.send(std::string_view(&c, 1));
  EXPECT_TRUE(client.line().starts_with("OK q1_mm=1.021 "));
  client.send("TARGET x_mm=0\nTARGET x_mm=1\nTARGET\n");
  EXPECT_TRUE(client.line().starts_with("OK q1_mm=1.021 "));
  EXPECT_TRUE(client.line().starts_with("OK q1_mm=3.5252 "));
  EXPECT_TRUE(client.line().starts_with("ERR MISSING_COORDINATE "));
}

TEST_F(TargetLine, ClosesAConnectionWhoseLineNeverEnds) {
  Client client(server_->address());
  client.send(std::string(600, 'x'));
  EXPECT_TRUE(client.line().starts_with("ERR LINE_TOO_LONG "));
  EXPECT_EQ(client.line(), "");
}

// Controllers that died without closing leave sockets that nobody writes to again.
TEST_F(TargetLine, GivesThePlaceOfTheLongestIdleClientToALiveOne) {
  std::vector<std::unique_ptr<Client>> dead;
  for (std::size_t i = 0; i < TargetLineServer::kMaxClients; ++i) {
    dead.push_back(std::make_unique<Client>(server_->address()));
    ASSERT_TRUE(dead.back()->ask("TARGET x_mm=0").starts_with("ERR NO_MODEL ")) << i;
  }
  const auto idle = std::chrono::steady_clock::now() + TargetLineServer::kIdle;
  Client live(server_->address());  // takes a place as soon as one has been idle for long enough
  std::string answer = live.ask("TARGET x_mm=0");
  while (answer.starts_with("ERR TOO_MANY_CLIENTS")) {
    Client again(server_->address());
    answer = again.ask("TARGET x_mm=0");
    if (std::chrono::steady_clock::now() > idle + std::chrono::seconds(10)) break;
  }
  EXPECT_TRUE(answer.starts_with("ERR NO_MODEL ")) << answer;
  EXPECT_EQ(dead.front()->line(), "") << "the longest idle one is closed";
  std::size_t open = 0;
  on_executor([&] { open = server_->clients(); });
  EXPECT_LE(open, TargetLineServer::kMaxClients);
}

TEST_F(TargetLine, TurnsAwayTheClientBeyondTheLimitWhileAllOthersAreAtWork) {
  std::vector<std::unique_ptr<Client>> clients;
  for (std::size_t i = 0; i < TargetLineServer::kMaxClients; ++i)
    clients.push_back(std::make_unique<Client>(server_->address()));
  std::string refused;
  for (int attempt = 0; attempt < 50 && !refused.starts_with("ERR TOO_MANY_CLIENTS"); ++attempt) {
    for (std::size_t i = 0; i < clients.size(); ++i) {
      const auto answer = clients[i]->ask("TARGET x_mm=0");
      ASSERT_TRUE(answer.starts_with("ERR NO_MODEL ")) << i << ": " << answer;
    }
    Client late(server_->address());
    refused = late.ask("TARGET x_mm=0");
    if (!refused.starts_with("ERR TOO_MANY_CLIENTS"))  // a slow machine: one was idle after all
      for (auto& client : clients) client = std::make_unique<Client>(server_->address());
  }
  EXPECT_TRUE(refused.starts_with("ERR TOO_MANY_CLIENTS ")) << refused;
  clients.pop_back();
  std::size_t open = TargetLineServer::kMaxClients;
  while (open >= TargetLineServer::kMaxClients) on_executor([&] { open = server_->clients(); });
  Client next(server_->address());
  EXPECT_TRUE(next.ask("TARGET x_mm=0").starts_with("ERR NO_MODEL "));
}

TEST_F(TargetLine, FlagsConditionsThatNobodyLookedAtInTime) {
  auto snapshot = snapshot_of(ModelId{3});
  snapshot.valid_until = tests::kTestEpoch - std::chrono::seconds(1);
  ASSERT_TRUE(board_.publish(std::move(snapshot)));
  Client client(server_->address());
  EXPECT_TRUE(client.ask("TARGET x_mm=0").ends_with("flags=EXPIRED_CONDITIONS"));
}

TEST_F(TargetLine, ClosesItsConnectionsWhenItStops) {
  Client client(server_->address());
  client.ask("TARGET x_mm=0");
  on_executor([this] { server_->stop(); });
  EXPECT_EQ(client.line(), "");
}

struct Case {
  const char* name;
  const char* address;
  const char* reason;
};
class BadTargetLineAddress : public testing::TestWithParam<Case> {};
TEST_P(BadTargetLineAddress, IsRefused) {
  asio::io_context context;
  tests::ManualClock clock;
  compensation::SnapshotBoard board;
  const tests::TemporaryFolder folder;
  const auto access = *access::Access::open({}, folder.path());
  const auto server = TargetLineServer::start(
      {context.get_executor(), context.get_executor(), board, clock, *access},
      {GetParam().address});
  ASSERT_FALSE(server);
  EXPECT_EQ(server.error().reason, GetParam().reason);
}
INSTANTIATE_TEST_SUITE_P(Table, BadTargetLineAddress,
                         testing::Values(Case{"NoPort", "127.0.0.1", "BAD_ADDRESS"},
                                         Case{"NoNumber", "127.0.0.1:x", "BAD_ADDRESS"},
                                         Case{"Name", "example.org:1", "BAD_ADDRESS"},
                                         Case{"World", "0.0.0.0:0", "LISTEN_NOT_LOOPBACK"}),
                         [](const auto& row) { return std::string(row.param.name); });

TEST_F(TargetLine, SaysThatAPortIsTaken) {
  const auto second = TargetLineServer::start(parts(), {server_->address()});
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().reason, "CANNOT_LISTEN");
  EXPECT_NE(second.error().message.find(server_->address()), std::string::npos);
}

}  // namespace
}  // namespace driftwise::line
