#include "server/access/authoriser.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/process.h"

namespace driftwise::access {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

class Notes final : public AccessWitness {
 public:
  void note(AccessNote what) override { all.push_back(std::move(what)); }
  std::vector<AccessNote> all;
};

class AuthoriserTest : public testing::Test {
 protected:
  AuthoriserTest() : book(std::move(*TokenBook::open(folder.path() + "/tokens.json", {16, 1, 1}))) {
    make(LoopbackRule::token);
  }
  void make(LoopbackRule loopback) {
    authoriser = std::make_unique<Authoriser>(Authoriser::Parts{.loopback = loopback,
                                                                .tokens = book.get(),
                                                                .local_token = kLocal,
                                                                .local_user = "daemon-user",
                                                                .steady = [this] { return now; },
                                                                .utc_s = [this] { return utc_s; }});
    authoriser->tell(&notes);
  }
  // A client certificate that is good until 2027-01-25.
  Evidence shown_by_robot() const {
    const auto openssl = [](std::vector<std::string> words) {
      words.insert(words.begin(), "/usr/bin/openssl");
      const auto done = tests::run_process(words);
      EXPECT_EQ(done.code, 0) << done.err;
    };
    const std::string key = folder.path() + "/robot.key", index = folder.path() + "/index",
                      settings = folder.path() + "/ca.cnf", request = folder.path() + "/robot.csr",
                      path = folder.path() + "/robot.pem";
    tests::write_file(index, "");
    tests::write_file(settings, "[ca]\ndefault_ca = own\n[own]\ndatabase = " + index +
                                    "\nnew_certs_dir = " + folder.path() +
                                    "\nrand_serial = yes\ndefault_md = sha256\npolicy = any\n"
                                    "[any]\ncommonName = supplied\n");
    openssl({"req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes",
             "-keyout", key, "-out", request, "-subj", "/CN=robot"});
    openssl({"ca", "-batch", "-config", settings, "-selfsign", "-keyfile", key, "-in", request,
             "-startdate", "20261101000000Z", "-enddate", "20270125000000Z", "-notext", "-out",
             path});
    return {.door = Door::tls,
            .from = kFrom,
            .certificate_name = "robot",
            .certificate_uris = {"driftwise:role/controller"},
            .certificate_pem = tests::read_file(path)};
  }
  std::string token(Role role) {
    return book->create(std::string(to_string(role)) + "-1", role, "ada", 1'800'000'000, {})->text;
  }

  const std::string kLocal = token_text(new_token());
  const std::string kFrom = "ipv4:10.0.0.2:4711";
  tests::TemporaryFolder folder;
  std::unique_ptr<TokenBook> book;
  WrongTries::Instant now{1000h};
  std::int64_t utc_s = 1'800'000'000;  // 2027-01-15
  Notes notes;
  std::unique_ptr<Authoriser> authoriser;
};

TEST_F(AuthoriserTest, TakesTheLocalSocketForAnAdmin) {
  const auto who = authoriser->identify({.door = Door::unix_socket, .from = "unix:"});
  ASSERT_TRUE(who);
  EXPECT_EQ(*who, (Identity{"daemon-user", Role::admin, Proof::local_socket, "", "unix:"}));
  EXPECT_EQ(authoriser->identify({.door = Door::unix_socket, .stated_name = "ada"})->name, "ada");
}

TEST_F(AuthoriserTest, GivesLoopbackNothingByItself) {
  const auto who = authoriser->identify({.door = Door::loopback, .stated_name = "ada"});
  ASSERT_FALSE(who);
  EXPECT_EQ(who.error().code, ErrorCode::unauthenticated);
  EXPECT_EQ(who.error().reason, "NO_IDENTITY");
  EXPECT_EQ(authoriser->identify({.door = Door::loopback, .bearer = kLocal})->role, Role::admin);
}

TEST_F(AuthoriserTest, LeavesLoopbackOpenWhereTheFileSaysSo) {
  make(LoopbackRule::open);
  EXPECT_EQ(authoriser->identify({.door = Door::loopback, .from = "x", .stated_name = "ada"}),
            (Identity{"ada", Role::admin, Proof::open_loopback, "", "x"}));
  EXPECT_EQ(authoriser->identify({.door = Door::loopback})->name, "unknown");
  EXPECT_FALSE(authoriser->identify({.door = Door::tls})) << "TLS stays closed";
  EXPECT_FALSE(authoriser->identify({.door = Door::loopback, .bearer = "dwt_wrong"}))
      << "a wrong token is wrong everywhere";
}

TEST_F(AuthoriserTest, ReadsTheRoleOfACertificate) {
  const auto identify = [&](std::vector<std::string> uris) {
    return authoriser->identify({.door = Door::tls,
                                 .from = kFrom,
                                 .stated_name = "somebody else",
                                 .certificate_name = "ada",
                                 .certificate_uris = std::move(uris)});
  };
  EXPECT_EQ(identify({"driftwise:role/operator"}),
            (Identity{"ada", Role::operator_, Proof::certificate, "", kFrom}));
  EXPECT_EQ(
      identify({"https://lab.example", "driftwise:role/viewer", "driftwise:role/engineer"})->role,
      Role::engineer)
      << "the highest";
  EXPECT_EQ(identify({}).error().reason, "NO_ROLE");
  EXPECT_EQ(identify({"driftwise:role/root"}).error().reason, "NO_ROLE");
}

TEST_F(AuthoriserTest, KnowsWhetherAnIdentityIsInForceStill) {
  const auto by_token = *authoriser->identify({.from = kFrom, .bearer = token(Role::engineer)});
  auto session = by_token;
  session.proof = Proof::page_session;
  EXPECT_TRUE(authoriser->in_force(by_token));
  EXPECT_TRUE(authoriser->in_force(session));
  ASSERT_TRUE(book->revoke(by_token.credential));
  EXPECT_FALSE(authoriser->in_force(by_token));
  EXPECT_FALSE(authoriser->in_force(session)) << "what was begun with it ends with it";
  EXPECT_TRUE(authoriser->in_force(*authoriser->identify({.bearer = kLocal})));
  EXPECT_TRUE(authoriser->in_force(*authoriser->identify({.door = Door::unix_socket})));
}

TEST_F(AuthoriserTest, KnowsWhichTokensAndShownCertificatesEndSoon) {
  constexpr std::int64_t kDay = 86'400, kNow = 1'800'000'000;  // 2027-01-15
  const auto a =
      book->create("press", Role::controller, "ada", kNow - 300 * kDay, kNow + 20 * kDay);
  book->create("stage", Role::controller, "ada", kNow - 300 * kDay, kNow + 60 * kDay).value();
  token(Role::viewer);  // without an end
  ASSERT_TRUE(authoriser->identify(shown_by_robot()));
  std::vector<std::string> subjects, further;
  for (const auto& one : authoriser->ending())
    (one.message.empty() ? further : subjects).push_back(one.subject);
  EXPECT_EQ(further.size(), 1U) << "the token of stage is known, and ends later";
  EXPECT_THAT(subjects,
              testing::UnorderedElementsAre("token " + a->record.id, "certificate of robot"));
}

TEST_F(AuthoriserTest, RefusesACertificateThatEndedWhileItsConnectionStands) {
  const auto shown = shown_by_robot();
  ASSERT_TRUE(authoriser->identify(shown));
  utc_s = 1'800'835'200;  // 2027-01-25, its end
  const auto refused = authoriser->identify(shown);
  ASSERT_FALSE(refused) << "the call was served";
  EXPECT_EQ(refused.error().code, ErrorCode::unauthenticated);
  EXPECT_EQ(refused.error().reason, "CERTIFICATE_EXPIRED");
  EXPECT_THAT(refused.error().message, HasSubstr("'robot' has ended on 2027-01-25"));
  EXPECT_THAT(notes.all.back().detail, HasSubstr("has ended"));
  EXPECT_THAT(authoriser->ending().front().message, HasSubstr("calls with it are refused"));
}

TEST_F(AuthoriserTest, KnowsGoodTokensWithoutAScrypt) {
  const std::string good = token(Role::operator_);
  EXPECT_FALSE(authoriser->knows(good)) << "it was not checked yet";
  ASSERT_TRUE(authoriser->identify({.from = kFrom, .bearer = good}));
  EXPECT_TRUE(authoriser->knows(good));
  EXPECT_TRUE(authoriser->knows(kLocal)) << "that of the state folder is in no book";
  EXPECT_FALSE(authoriser->knows("dwt_wrong"));
  EXPECT_FALSE(authoriser->knows(""));
}

TEST_F(AuthoriserTest, TakesTheTokenOverTheCertificate) {
  const auto who = authoriser->identify({.door = Door::tls,
                                         .from = kFrom,
                                         .bearer = token(Role::viewer),
                                         .certificate_name = "ada",
                                         .certificate_uris = {"driftwise:role/admin"}});
  ASSERT_TRUE(who);
  EXPECT_EQ(who->role, Role::viewer);
  EXPECT_EQ(who->name, "viewer-1");
}

TEST_F(AuthoriserTest, SaysWhoMayNotAndWhatIsNeeded) {
  const Identity ada{"ada", Role::viewer, Proof::token, "k3f9a2c1", kFrom};
  EXPECT_TRUE(authoriser->authorise(ada, {"StopAll", Role::viewer}));
  const auto refused = authoriser->authorise(ada, {"Home", Role::operator_});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::permission_denied);
  EXPECT_EQ(refused.error().reason, "NEEDS_ROLE");
  EXPECT_EQ(refused.error().message,
            "ada (token k3f9a2c1, viewer, from ipv4:10.0.0.2:4711) may not Home: it needs the role "
            "operator, this is viewer");
  ASSERT_EQ(notes.all.size(), 1U);
  EXPECT_EQ(notes.all[0].kind, AccessNote::Kind::refused);
  EXPECT_EQ(notes.all[0].detail, refused.error().message);
  EXPECT_EQ(notes.all[0].act, "Home");
  EXPECT_EQ(notes.all[0].proof, "token k3f9a2c1");
}

TEST_F(AuthoriserTest, SlowsWrongTokensByAddressAndNoKnownOne) {
  const std::string good = token(Role::operator_);
  ASSERT_TRUE(authoriser->identify({.door = Door::tls, .from = kFrom, .bearer = good}));
  for (int i = 0; i < WrongTries::kFree; ++i)
    EXPECT_EQ(
        authoriser->identify({.door = Door::tls, .from = kFrom, .bearer = "dwt_x"}).error().reason,
        "BAD_TOKEN");
  EXPECT_EQ(notes.all.back().kind, AccessNote::Kind::locked);
  const auto fresh = token(Role::viewer);
  EXPECT_EQ(
      authoriser->identify({.door = Door::tls, .from = kFrom, .bearer = fresh}).error().reason,
      "TOO_MANY_TRIES")
      << "not looked at";
  EXPECT_TRUE(authoriser->identify({.door = Door::tls, .from = kFrom, .bearer = good}))
      << "who was in stays in";
  EXPECT_TRUE(authoriser->identify({.door = Door::loopback, .from = kFrom, .bearer = kLocal}));
  EXPECT_TRUE(
      authoriser->identify({.door = Door::tls, .from = "ipv4:10.0.0.3:1", .bearer = fresh}));
  now += 1s;
  EXPECT_TRUE(
      authoriser->identify({.door = Door::tls, .from = kFrom, .bearer = token(Role::admin)}));
}

TEST_F(AuthoriserTest, TellsABoundedNumberAndCountsTheRest) {
  const Identity eve{"eve", Role::viewer, Proof::token, "x", kFrom};
  for (int i = 0; i < 1000; ++i)
    static_cast<void>(authoriser->authorise(eve, {"Home", Role::admin}));
  EXPECT_EQ(notes.all.size(), static_cast<std::size_t>(Authoriser::kMostToldPerMinute));
  now += 61s;
  static_cast<void>(authoriser->authorise(eve, {"Home", Role::admin}));
  EXPECT_EQ(notes.all.back().count, 1000 - Authoriser::kMostToldPerMinute + 1);
  EXPECT_THAT(notes.all.back().detail, HasSubstr("980 more"));
}

TEST_F(AuthoriserTest, VouchesForTheGatewayOnly) {
  const Identity ada{"Zoë", Role::engineer, Proof::page_session, "s1", "ipv4:10.0.0.9:1"};
  const std::string bytes = authoriser->vouch(ada);
  EXPECT_EQ(authoriser->vouched(bytes), ada);
  EXPECT_EQ(authoriser->vouched(""), std::nullopt);
  EXPECT_EQ(authoriser->vouched(bytes.substr(1)), std::nullopt);
  std::string forged = bytes;
  forged[3] = static_cast<char>(forged[3] ^ 1);
  EXPECT_EQ(authoriser->vouched(forged), std::nullopt);
  const Authoriser other({});
  EXPECT_EQ(other.vouched(bytes), std::nullopt) << "of another start";
}

TEST_F(AuthoriserTest, ShowsNothingThatATerminalWouldObey) {
  const auto who = authoriser->identify({.door = Door::tls,
                                         .from = kFrom,
                                         .certificate_name = "a\x1b[2Jb\nc",
                                         .certificate_uris = {"driftwise:role/viewer"}});
  ASSERT_TRUE(who);
  EXPECT_EQ(who->name, "a?[2Jb c");
}

}  // namespace
}  // namespace driftwise::access
