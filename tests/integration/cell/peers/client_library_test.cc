// Driftwise::client against a running daemon: the same target as by every other door, a follower
// that follows, and a loss that is said and mended.

#include <gmock/gmock.h>
#include <stdlib.h>
#include <unistd.h>

#include "clients/cpp/include/driftwise/client.h"
#include "clients/cpp/link.h"
#include "driftwise/v1/cell_service.grpc.pb.h"
#include "tests/integration/cell/cell_at_work.h"
#include "tests/integration/cell/served_model.h"

namespace driftwise::tests {
namespace {

using std::chrono::seconds;

// Waits for the follower's next news until `holds`, for at most a minute.
template <class Holds>
bool news_until(const client::TargetFollower& follower, Holds holds) {
  const auto end = std::chrono::steady_clock::now() + seconds(60);
  auto seen = follower.sequence();
  while (!holds(follower.latest())) {
    if (std::chrono::steady_clock::now() > end) return false;
    seen = follower.wait(seen, std::chrono::milliseconds(200));
  }
  return true;
}

TEST(ClientLibrary, GivesTheTargetThatTheCommandLineGives) {
  CellAtWork cell;
  cell.edit_cell_file("rebuild_period_s = 5.0", "rebuild_period_s = 3600.0");
  cell.start_daemon();
  const auto model = serve_known_model(cell);
  const client::Client library(cell.grpc_address(), "Ada Lovelace");
  // No new temperatures: the conditions stay what they are long enough to ask three times.
  cell.control("fault mute scanner 1000000 s");
  bool one_snapshot = false;
  for (int tries = 0; tries < 20 && !one_snapshot; ++tries) {
    const auto before = cell.ask({"target", "x=1.25"});
    const auto mine = library.target({{"x_mm", 1.25}}, seconds(20));
    const auto after = cell.ask({"target", "x=1.25"});
    ASSERT_TRUE(mine.has_value()) << mine.error().message;
    one_snapshot = before.at("conditions_time") == after.at("conditions_time");
    if (!one_snapshot) continue;
    ASSERT_EQ(mine->coordinates.size(), 1u);
    EXPECT_EQ(mine->coordinates[0].channel, "q1_mm");
    EXPECT_EQ(mine->coordinates[0].position_mm,
              before.at("coordinates").at(0).at("position_mm").get<double>());
    EXPECT_EQ(mine->coordinates[0].u90_nm,
              before.at("coordinates").at(0).at("u90_nm").get<double>());
    EXPECT_EQ(mine->model_id, model);
    EXPECT_GT(mine->valid_until, mine->conditions_time);
  }
  EXPECT_TRUE(one_snapshot);
}

TEST(ClientLibrary, SaysWhyThereIsNoTarget) {
  CellAtWork cell;
  cell.start_daemon();
  const client::Client library(cell.grpc_address());
  const auto none_serves = library.target({{"x_mm", 1.0}}, seconds(20));
  ASSERT_FALSE(none_serves.has_value());
  EXPECT_EQ(none_serves.error().reason, "NO_MODEL");
  serve_known_model(cell);
  const auto beyond = library.target({{"x_mm", 2 * kServedLimit_mm}}, seconds(20));
  ASSERT_FALSE(beyond.has_value());
  EXPECT_EQ(beyond.error().reason, "OUTSIDE_LIMITS(q1)");
  // Beyond what the model was fitted on, within the soft limits of 5 mm.
  const auto outside = library.target({{"x_mm", 1.1 * kServedLimit_mm}}, seconds(20));
  ASSERT_TRUE(outside.has_value()) << outside.error().message;
  EXPECT_THAT(outside->flags, testing::Contains(testing::HasSubstr("OUTSIDE_DOMAIN(x_mm")));
  EXPECT_FALSE(outside->plain());
  const client::Client nobody("127.0.0.1:1");
  const auto no_daemon = nobody.target({{"x_mm", 1.0}}, seconds(5));
  ASSERT_FALSE(no_daemon.has_value());
  EXPECT_EQ(no_daemon.error().reason, "NO_DAEMON");
}

// A loopback address of this process alone. A port that is given up and taken again on 127.0.0.1
// may meanwhile be the source port of somebody else's connection.
std::string own_loopback_address() {
  const int pid = ::getpid();
  return "127." + std::to_string(64 + (pid >> 16) % 64) + "." + std::to_string((pid >> 8) % 256) +
         "." + std::to_string(1 + pid % 254);
}

TEST(ClientLibrary, FollowsTheTemperaturesAndComesBackAfterTheDaemonWasKilled) {
  CellAtWork cell;
  const std::string any_port = "listen = \"" + own_loopback_address() + ":0\"";
  cell.edit_cell_file("listen = \"127.0.0.1:0\"", any_port);
  cell.start_daemon();
  serve_known_model(cell);
  const auto address = client::address_in(cell.folder() + "/driftwised.json");
  ASSERT_TRUE(address.has_value()) << address.error().message;
  const auto follower = client::Client(*address).follow({{"x_mm", 0.5}});
  const auto is_target = [](const auto& latest) { return latest.has_value(); };
  ASSERT_TRUE(news_until(follower, is_target)) << follower.latest().error().message;
  const auto first = *follower.latest();
  EXPECT_TRUE(news_until(follower, [&](const auto& latest) {
    return latest && latest->conditions_time > first.conditions_time;
  })) << "no newer conditions in a minute";

  cell.kill_daemon();
  ASSERT_TRUE(news_until(follower, [](const auto& latest) { return !latest; }))
      << "an old target was shown as the present one after the daemon was gone";
  EXPECT_EQ(follower.latest().error().reason, "NO_DAEMON");

  // The same door again: the port that the system had picked.
  cell.edit_cell_file(any_port, "listen = \"" + *address + "\"");
  cell.start_daemon();
  EXPECT_TRUE(news_until(follower, is_target)) << follower.latest().error().message;
}

TEST(ClientLibrary, ConnectsAgainWhileNobodyAsks) {
  // gRPC's own poller, which comes every 5 s, would come after the test.
  ::setenv("GRPC_CLIENT_CHANNEL_BACKUP_POLL_INTERVAL_MS", "600000", 1);
  CellAtWork cell;
  const std::string any_port = "listen = \"" + own_loopback_address() + ":0\"";
  cell.edit_cell_file("listen = \"127.0.0.1:0\"", any_port);
  cell.start_daemon();
  const auto address = cell.grpc_address();
  const client::Link link(address, "", {});
  const auto asked = [&link] {
    grpc::ClientContext context;
    v1::GetStatusResponse response;
    return v1::CellService::NewStub(link.channel)->GetStatus(&context, {}, &response);
  };
  ASSERT_TRUE(asked().ok());
  cell.kill_daemon();
  wait_until("a refused attempt to connect, after which calls fail at once",
             [&] { return link.failure_of(asked()).message.find("refused") != std::string::npos; });
  cell.edit_cell_file(any_port, "listen = \"" + address + "\"");
  cell.start_daemon();
  wait_until("the connection", [&] { return link.channel->GetState(false) == GRPC_CHANNEL_READY; });
}

TEST(ClientLibrary, NamesWhatIsWrongWithAnAddressFile) {
  const TemporaryFolder folder;
  const auto missing = client::address_in(folder.path() + "/driftwised.json");
  ASSERT_FALSE(missing.has_value());
  EXPECT_EQ(missing.error().reason, "NO_NOTICE");
}

}  // namespace
}  // namespace driftwise::tests
