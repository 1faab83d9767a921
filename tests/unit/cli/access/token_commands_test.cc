// driftwise token: what is asked for reaches the book.

#include "server/access/access.h"
#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

class TokenCommands : public CliTest {
 protected:
  void SetUp() override {
    auto entering = access::Access::open({}, folder.path());
    if (!entering) throw std::runtime_error(entering.error().message);
    access = std::move(*entering);
    auto opened = rpc::RpcServer::open(cell.services(fakes), "127.0.0.1:0", {}, access.get());
    if (!opened) throw std::runtime_error(opened.error().message);
    server = std::move(*opened);
    server->ready(true);
    environment = {{"DRIFTWISE_SERVER", server->address()}, {"USER", "ada"}};
  }
  void TearDown() override {
    server.reset();
    access->authoriser().tell(nullptr);
  }

  std::unique_ptr<access::Access> access;
};

TEST_F(TokenCommands, MakeATokenThatEndsInAHundredYears) {
  const auto made = run({"token", "create", "press", "--role", "viewer", "--days", "36500"});
  ASSERT_EQ(made.exit, 0) << made.err;
  const auto record = access->tokens().list().front();
  ASSERT_TRUE(record.expires_utc_s);
  // The program and the daemon look at the clock one after the other.
  EXPECT_NEAR(static_cast<double>(*record.expires_utc_s - record.created_utc_s), 36'500.0 * 86'400,
              30);
}

TEST_F(TokenCommands, RefuseAnEndThatNoClockReaches) {
  const auto refused = run({"token", "create", "press", "--role", "viewer", "--days", "99999"});
  EXPECT_EQ(refused.exit, 2);
  EXPECT_THAT(refused.err,
              HasSubstr("--days: found '99999', expected a number from 0.001 to 36500"));
  EXPECT_TRUE(access->tokens().list().empty());
}

}  // namespace
}  // namespace driftwise::tests
