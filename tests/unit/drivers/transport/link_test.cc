#include "drivers/transport/link.h"

#include <boost/asio/post.hpp>
#include <list>

#include "drivers/transport/tcp_stream.h"
#include "tests/unit/drivers/driver_fixture.h"

namespace driftwise::transport {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using tests::expect;
using tests::hang_up;
using tests::send;

class TcpLink : public tests::DriverFixture {
 protected:
  std::unique_ptr<Link> make(LinkSettings settings) {
    settings.device = "axis";
    settings.address = peer.address();
    settings.back_off = {40ms, 80ms};
    const auto address = parse_address(peer.address());
    return std::make_unique<Link>(context.get_executor(), clock, settings,
                                  make_stream(context.get_executor(), *address, {}));
  }
  std::unique_ptr<Link> connected(LinkSettings settings = {}) {
    auto link = make(std::move(settings));
    EXPECT_TRUE(run(link->connect(kTimeout)));
    return link;
  }
  LinkSettings with_marker() {
    LinkSettings out;
    out.resync_request = "ID?\n";
    out.is_resync_reply = [](std::string_view reply) { return reply == "me"; };
    return out;
  }
  Result<std::string> ask(Link& link, std::string request, int replies = 1) {
    return run(link.ask(std::move(request), kTimeout, replies));
  }
  std::unique_ptr<Link> make_by_name(LookUp look_up) {
    LinkSettings settings;
    settings.back_off = {40ms, 80ms};
    return std::make_unique<Link>(
        context.get_executor(), clock, settings,
        make_tcp_stream(context.get_executor(), {"axis.lab", 1}, std::move(look_up)));
  }
  LookUp finds(Endpoints all) {
    return [this, all = std::move(all)](const TcpAddress&, Found found) {
      asio::post(context, [all, found = std::move(found)] { found({}, all); });
    };
  }
  static constexpr Nanoseconds kTimeout{250ms};
};

// Listens, never accepts, and its backlog is full: whoever knocks hears nothing.
class Hole {
 public:
  explicit Hole(asio::io_context& context) : acceptor_(context) {
    const asio::ip::tcp::endpoint any(asio::ip::address_v4::loopback(), 0);
    acceptor_.open(any.protocol());
    acceptor_.bind(any);
    acceptor_.listen(0);
    for (int i = 0; i < 6; ++i)
      waiting_.emplace_back(context).async_connect(endpoint(), [](error_code) {});
  }
  asio::ip::tcp::endpoint endpoint() const { return acceptor_.local_endpoint(); }

 private:
  asio::ip::tcp::acceptor acceptor_;
  std::list<asio::ip::tcp::socket> waiting_;
};

TEST_F(TcpLink, PutsAReplyTogetherThatArrivesInPieces) {
  peer.on_connection(
      {expect("Q\n"), send("1."), send("2"), send("5\r"), send("\n"), expect("R\n"), send("2\n")});
  auto link = connected();
  EXPECT_EQ(*ask(*link, "Q\n"), "1.25\r");
  EXPECT_EQ(without_line_ends(*ask(*link, "R\n")), "2");
}

TEST_F(TcpLink, TakesSeveralRepliesThatArriveAsOne) {
  peer.on_connection({expect("AB"), send("1\n2\n")});
  auto link = connected();
  EXPECT_EQ(*ask(*link, "AB", 2), "1\n2\n");
}

TEST_F(TcpLink, SaysWhoWasAskedWhatWhenNothingComes) {
  peer.on_connection({expect("POS?\n"), send("X=1")});
  auto link = connected();
  const auto reply = ask(*link, "POS?\n");
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().code, ErrorCode::deadline_exceeded);
  EXPECT_THAT(reply.error().message,
              AllOf(HasSubstr("'axis'"), HasSubstr(peer.address()), HasSubstr("\"POS?\\n\""),
                    HasSubstr("\"X=1\""), HasSubstr(" ms")));
  EXPECT_EQ(link->health().errors, 1);
  EXPECT_THAT(link->log().lines().back(), HasSubstr("POS?"));
}

TEST_F(TcpLink, NeverTakesALateReplyForTheNextOne) {
  peer.on_connection({expect("A\n"),  // answered only when the next question is there
                      expect("ID?\n"), send("late\n"), send("me\n"), expect("B\n"), send("b\n")});
  auto link = connected(with_marker());
  EXPECT_EQ(ask(*link, "A\n").error().reason, "TIMEOUT");
  EXPECT_EQ(*ask(*link, "B\n"), "b\n");
  EXPECT_EQ(link->generation(), 1);
}

TEST_F(TcpLink, StartsOverAfterATimeoutWhenNothingMarksTheNextAnswer) {
  peer.on_connection({expect("A\n")});
  peer.on_connection({expect("B\n"), send("b\n")});
  auto link = connected();
  EXPECT_EQ(ask(*link, "A\n").error().reason, "TIMEOUT");
  EXPECT_FALSE(link->connected());
  EXPECT_EQ(ask(*link, "B\n").error().reason,
            "LINK_DOWN");  // its owner connects, and sets the device up again
  ASSERT_TRUE(run(link->connect(kTimeout)));
  EXPECT_EQ(*ask(*link, "B\n"), "b\n");
  EXPECT_EQ(link->generation(), 2);
  EXPECT_EQ(link->health().reconnects, 1);
}

TEST_F(TcpLink, DropsADeviceThatDoesNotComeBackInStep) {
  peer.on_connection({expect("A\n"), expect("ID?\n")});
  auto link = connected(with_marker());
  EXPECT_EQ(ask(*link, "A\n").error().reason, "TIMEOUT");
  EXPECT_FALSE(ask(*link, "B\n"));
  EXPECT_FALSE(link->connected());
}

TEST_F(TcpLink, ThrowsAwayWhatCameUnasked) {
  peer.on_connection({send("hello\n"), expect("Q\n"), send("1\n")});
  auto link = connected();
  until([&] { return peer.sent() == 1; });  // on loopback what is sent has arrived
  EXPECT_EQ(*ask(*link, "Q\n"), "1\n");
  EXPECT_THAT(link->log().lines().front(), HasSubstr("hello"));
}

TEST_F(TcpLink, NoticesALineClosedWhileNobodyAsked) {
  peer.on_connection({expect("A\n"), send("a\n"), hang_up()});
  peer.on_connection({expect("B\n"), send("b\n")});
  auto link = connected();
  EXPECT_TRUE(ask(*link, "A\n"));
  let_pass(20ms);
  ASSERT_TRUE(run(link->connect(kTimeout)));
  EXPECT_EQ(link->generation(), 2);
  EXPECT_EQ(*ask(*link, "B\n"), "b\n");
}

TEST_F(TcpLink, SaysThatTheLineWasClosedWhileNobodyAsked) {
  peer.on_connection({expect("A\n"), send("a\n"), hang_up()});
  auto link = connected();
  EXPECT_TRUE(ask(*link, "A\n"));
  let_pass(20ms);
  const auto reply = ask(*link, "B\n");
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().reason, "LINK_LOST");
  EXPECT_THAT(reply.error().message, HasSubstr("Connection reset by peer"));  // not EBADF
}

TEST_F(TcpLink, SaysThatTheLineBroke) {
  peer.on_connection({expect("A\n"), send("x"), hang_up()});
  auto link = connected();
  const auto reply = ask(*link, "A\n");
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().reason, "LINK_LOST");
  EXPECT_THAT(reply.error().message, HasSubstr("\"x\""));
}

TEST_F(TcpLink, BoundsWhatADeviceMayAnswer) {
  peer.on_connection({expect("A\n"), send(std::string(3000, 'x'))});
  LinkSettings settings;
  settings.max_reply_bytes = 1000;
  auto link = connected(settings);
  const auto reply = ask(*link, "A\n");
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().reason, "REPLY_TOO_LONG");
  EXPECT_LT(reply.error().message.size(), 600u);
}

TEST_F(TcpLink, BacksOffFromADeviceThatIsAwayAndComesBackToIt) {
  auto link = make({});
  peer.stop_listening();
  const auto down = run(link->connect(kTimeout));
  ASSERT_FALSE(down);
  EXPECT_EQ(down.error().code, ErrorCode::unavailable);
  EXPECT_THAT(down.error().message, AllOf(HasSubstr("axis"), HasSubstr(peer.address())));
  EXPECT_FALSE(run(link->connect(kTimeout)));  // at once; from here on it waits
  const auto before = std::chrono::steady_clock::now();
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(run(link->connect(kTimeout)));
  EXPECT_GE(std::chrono::steady_clock::now() - before, 20ms + 40ms + 40ms);
  peer.listen_again();
  EXPECT_TRUE(run(link->connect(kTimeout)));
  EXPECT_EQ(link->health().link, LinkState::connected);
}

TEST_F(TcpLink, BacksOffFromADeviceThatAnswersAndCannotBeSetUp) {
  LinkSettings settings;
  settings.back_off = {1000ms, 1000ms};
  Link link(context.get_executor(), clock, settings,
            make_stream(context.get_executor(), *parse_address(peer.address()), {}));
  const auto time_to_connect = [&] {
    peer.on_connection({expect("ID?\n"), send("me\n")});
    const auto before = std::chrono::steady_clock::now();
    EXPECT_TRUE(run(link.connect(Nanoseconds(2s))));
    const auto took = std::chrono::steady_clock::now() - before;
    EXPECT_TRUE(ask(link, "ID?\n"));
    return took;
  };
  const Error refusal{ErrorCode::failed_precondition, "WRONG_DEVICE", "expected another one"};
  for (int i = 0; i < 2; ++i) {
    time_to_connect();
    link.drop(refusal);
  }
  EXPECT_GE(time_to_connect(), 500ms);
  link.drop(refusal);
  const auto meanwhile = run(link.connect(kTimeout));
  ASSERT_FALSE(meanwhile);
  EXPECT_EQ(meanwhile.error().reason, "WRONG_DEVICE") << "as long as it waits";
  link.interrupt({}, "STOPPED");
  EXPECT_LT(time_to_connect(), 500ms) << "a stop does not wait";
  link.device_is_set_up();
  link.drop("broken");
  EXPECT_LT(time_to_connect(), 500ms) << "at once after a success";
}

TEST_F(TcpLink, FindsAHostByItsName) {
  peer.on_connection({expect("A\n"), send("a\n")});
  const auto address = std::get<TcpAddress>(*parse_address(peer.address()));
  Link link(context.get_executor(), clock, {},
            make_tcp_stream(context.get_executor(), {"localhost", address.port}));
  ASSERT_TRUE(run(link.connect(Nanoseconds(5s))));
  EXPECT_EQ(*ask(link, "A\n"), "a\n");
}

TEST_F(TcpLink, ItsTimeOutHoldsForAllAddressesOfAName) {
  Hole first(context), second(context);
  let_pass(50ms);
  auto link = make_by_name(finds({first.endpoint(), second.endpoint()}));
  const auto before = std::chrono::steady_clock::now();
  const auto down = run(link->connect(kTimeout));
  EXPECT_LT(std::chrono::steady_clock::now() - before, 2s);
  ASSERT_FALSE(down);
  EXPECT_THAT(down.error().message, HasSubstr("no connection within"));
}

TEST_F(TcpLink, BeginsWithAnotherAddressOfTheNameAfterOneThatIsSilent) {
  Hole silent(context);
  let_pass(50ms);
  peer.on_connection({expect("A\n"), send("a\n")});
  const auto address = std::get<TcpAddress>(*parse_address(peer.address()));
  auto link =
      make_by_name(finds({silent.endpoint(), {asio::ip::address_v4::loopback(), address.port}}));
  EXPECT_FALSE(run(link->connect(kTimeout)));
  ASSERT_TRUE(run(link->connect(kTimeout)));
  EXPECT_EQ(*ask(*link, "A\n"), "a\n");
}

TEST_F(TcpLink, ItsTimeOutAndAStopEndALookUp) {
  std::vector<Found> asked;
  auto link = make_by_name([&](const TcpAddress&, Found found) { asked.push_back(found); });
  const auto before = std::chrono::steady_clock::now();
  EXPECT_EQ(run(link->connect(kTimeout)).error().reason, "LINK_DOWN");
  asio::steady_timer later(context, 20ms);
  later.async_wait([&](auto) { link->interrupt({}, "STOPPED"); });
  const auto stopped = run(link->connect(Nanoseconds(60s)));
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().reason, "STOPPED");
  EXPECT_LT(std::chrono::steady_clock::now() - before, 5s);
  ASSERT_EQ(asked.size(), 2u);
  link = nullptr;
  for (const auto& found : asked) found({}, {});  // an answer that nobody waits for
  let_pass(10ms);
}

TEST_F(TcpLink, IsTriedAgainAtOnceAfterAStopThatEndedAConnection) {
  std::vector<Found> asked;
  auto link = make_by_name([&](const TcpAddress&, Found found) { asked.push_back(found); });
  // Twice: the first failure after a success has no wait.
  (void)run(link->connect(kTimeout));
  (void)run(link->connect(kTimeout));
  const std::string why = link->health().last_error;
  asio::steady_timer later(context, 20ms);
  later.async_wait([&](auto) { link->interrupt({}, "STOPPED"); });
  EXPECT_EQ(run(link->connect(Nanoseconds(60s))).error().reason, "STOPPED");
  EXPECT_EQ(link->health().last_error, why) << "a stop is no error of the device";
  const auto before = std::chrono::steady_clock::now();
  const auto lookups = asked.size();
  (void)run(link->connect(kTimeout));
  EXPECT_EQ(asked.size(), lookups + 1) << "no look-up: it waits";
  EXPECT_LT(std::chrono::steady_clock::now() - before, 2 * kTimeout);
  link = nullptr;
  for (const auto& found : asked) found({}, {});
  let_pass(10ms);
}

TEST_F(TcpLink, ForgetsAnErrorThatIsOverWhenItsDeviceIsSetUp) {
  auto link = make({});
  peer.stop_listening();
  EXPECT_FALSE(run(link->connect(kTimeout)));
  EXPECT_THAT(link->health().last_error, HasSubstr("cannot connect"));
  peer.listen_again();
  ASSERT_TRUE(run(link->connect(kTimeout)));
  EXPECT_NE(link->health().last_error, "") << "nobody has answered yet";
  link->device_is_set_up();
  EXPECT_EQ(link->health().last_error, "");
}

TEST_F(TcpLink, CountsADeviceAsSetUpUntilAnAnswerDoesNotCome) {
  peer.on_connection({expect("A\n"), send("a\n"), expect("B\n"), expect("ID?\n"), send("me\n")});
  auto link = connected(with_marker());
  EXPECT_FALSE(link->is_set_up());
  link->device_is_set_up();
  EXPECT_TRUE(ask(*link, "A\n"));
  EXPECT_TRUE(link->is_set_up());
  EXPECT_FALSE(ask(*link, "B\n"));
  EXPECT_TRUE(link->connected());
  EXPECT_FALSE(link->is_set_up()) << "it may have been switched off and on";
  EXPECT_TRUE(run(link->get_in_step(kTimeout)));
  EXPECT_FALSE(link->is_set_up()) << "its identity is no proof of it";
}

TEST_F(TcpLink, WaitsForTheBackOffNoLongerThanItsTimeout) {
  LinkSettings settings;
  auto link = make(settings);
  peer.stop_listening();
  (void)run(link->connect(kTimeout));
  link->drop("test");
  link = nullptr;
  settings.device = "axis";
  settings.address = peer.address();
  settings.back_off = {5000ms, 5000ms};
  Link patient(context.get_executor(), clock, settings,
               make_stream(context.get_executor(), *parse_address(peer.address()), {}));
  (void)run(patient.connect(kTimeout));
  (void)run(patient.connect(kTimeout));
  const auto before = std::chrono::steady_clock::now();
  const auto down = run(patient.connect(kTimeout));
  EXPECT_LT(std::chrono::steady_clock::now() - before, 1s);
  ASSERT_FALSE(down);
  EXPECT_THAT(down.error().message, HasSubstr("next attempt in"));
}

TEST_F(TcpLink, IsInterruptedAtOnceAndComesBackInStep) {
  peer.on_connection({expect("SLOW\n"), expect("\x18"), expect("ID?\n"), send("slow\n"),
                      send("me\n"), expect("B\n"), send("b\n")});
  auto link = connected(with_marker());
  asio::steady_timer later(context, 20ms);
  later.async_wait([&](auto) { link->interrupt("\x18", "STOPPED"); });
  const auto reply = run(link->ask("SLOW\n", Nanoseconds(5s)));
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().code, ErrorCode::aborted);
  EXPECT_EQ(reply.error().reason, "STOPPED");
  EXPECT_EQ(*ask(*link, "B\n"), "b\n");
}

TEST_F(TcpLink, AnswersBusyRatherThanMixTwoConversations) {
  peer.on_connection({expect("A\n")});
  auto link = connected();
  std::optional<Result<std::string>> second;
  asio::steady_timer later(context, 10ms);
  later.async_wait([&](auto) {
    asio::co_spawn(context, link->ask("B\n", kTimeout),
                   [&](std::exception_ptr, Result<std::string> r) { second = r; });
  });
  EXPECT_EQ(ask(*link, "A\n").error().reason, "TIMEOUT");
  ASSERT_TRUE(second);
  EXPECT_EQ(second->error().reason, "BUSY");
}

TEST_F(TcpLink, KeepsTheLastExchangesOnly) {
  tests::Script script;
  for (int i = 0; i < 20; ++i) {
    script.push_back(expect("Q\n"));
    script.push_back(send(std::to_string(i) + "\n"));
  }
  peer.on_connection(script);
  auto link = connected();
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(ask(*link, "Q\n"));
  EXPECT_EQ(link->log().entries().size(), 16u);
  EXPECT_EQ(link->log().entries().back().received, "19\n");
  EXPECT_EQ(link->health().exchanges, 20);
}

}  // namespace
}  // namespace driftwise::transport
