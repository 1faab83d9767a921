// Controllers at doors with TLS: Python, C++, Octave and bare bytes get the same target by a
// certificate or a token, and are refused alike without.

#include <gmock/gmock.h>

#include <filesystem>

#include "clients/cpp/include/driftwise/client.h"
#include "tests/integration/cell/cell_at_work.h"
#include "tests/integration/cell/peers/tcp_line.h"
#include "tests/integration/cell/served_model.h"
#include "tests/support/tls_client.h"

namespace driftwise::tests {
namespace {

using std::chrono::minutes;
using std::chrono::seconds;
using testing::HasSubstr;
using testing::StartsWith;

const std::string kClients = std::string(DRIFTWISE_SOURCE_DIR) + "/clients";

class SecuredDoors : public testing::Test {
 protected:
  // more: further keys of [access]. Loopback is open, so that the test itself needs no token.
  void start(const std::string& more = {}) {
    const std::string loopback = "open";
    cell.edit_cell_file("[cell]\n", "[access]\nlisten = \"127.0.0.1:0\"\nloopback = \"" + loopback +
                                        "\"\ncertificate = \"" + certificates.path("server.pem") +
                                        "\"\nkey = \"" + certificates.path("server-key.pem") +
                                        "\"\nauthority = \"" + certificates.path("authority.pem") +
                                        "\"\ntarget_line = \"127.0.0.1:0\"\n" + more +
                                        "\n[cell]\n");
    cell.start_daemon();
  }
  nlohmann::json notice() const {
    return nlohmann::json::parse(read_file(cell.folder() + "/driftwised.json"));
  }
  // A file with a token.
  std::string token(const std::string& name, const std::string& role) {
    const std::string path = cell.folder() + "/" + name + ".token";
    cell.say({"token", "create", name, "--role", role, "-o", path});
    return path;
  }
  static std::string text_of(const std::string& token_file) {
    auto text = read_file(token_file);
    while (text.ends_with('\n')) text.pop_back();
    return text;
  }
  Finished python(const std::vector<std::string>& options) const {
    std::vector<std::string> words = {"/usr/bin/python3", kClients + "/python/driftwise.py", "--ca",
                                      certificates.path("authority.pem")};
    words.insert(words.end(), options.begin(), options.end());
    return run_process(words, minutes(1), {"PYTHONDONTWRITEBYTECODE=1"});
  }
  static bool has_grpcio() {
    return run_process({"/usr/bin/python3", "-c", "import grpc, google.protobuf"}).code == 0;
  }

  CellAtWork cell;
  const TemporaryFolder folder;
  const TestCertificates certificates{folder.path()};
};

TEST_F(SecuredDoors, GiveTargetsToControllersByTokenAndByCertificate) {
  start();
  serve_known_model(cell);
  const std::string address = notice().at("grpc_tls"), line = notice().at("target_line_tls");
  const auto stage = token("stage", "controller");
  const auto shown = certificates.client("press", "driftwise:role/controller");
  const auto authority = certificates.path("authority.pem");

  const client::Client by_token(address, "stage", {authority, "", "", text_of(stage)});
  const auto first = by_token.target({{"x_mm", 1.5}}, seconds(20));
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_EQ(first->coordinates.at(0).channel, "q1_mm");
  const client::Client by_certificate(address, "press",
                                      {authority, shown.certificate, shown.key, ""});
  EXPECT_TRUE(by_certificate.target({{"x_mm", 1.5}}, seconds(20)));

  TlsClient bytes(line, certificates.nobody());
  EXPECT_EQ(bytes.ask("TOKEN " + text_of(stage)), "OK name=stage role=controller");
  EXPECT_THAT(bytes.ask("TARGET x_mm=1.5"), StartsWith("OK q1_mm="));
  TlsClient certified(line, shown);
  EXPECT_THAT(certified.ask("TARGET x_mm=1.5"), StartsWith("OK q1_mm="));

  if (!has_grpcio()) GTEST_SKIP() << "python3-grpcio is not installed: Python was not asked";
  for (const auto& proof :
       {std::vector<std::string>{"--token-file", stage},
        std::vector<std::string>{"--cert", shown.certificate, "--key", shown.key}}) {
    auto words = proof;
    words.insert(words.end(), {address, "x_mm=1.5"});
    const auto answer = python(words);
    ASSERT_EQ(answer.code, 0) << answer.err;
    EXPECT_THAT(nlohmann::json::parse(answer.out).at("q1_mm").get<double>(),
                testing::DoubleNear(first->coordinates.at(0).position_mm, 1e-3))
        << "temperatures move meanwhile";
  }
}

TEST_F(SecuredDoors, RefuseWhoHasNoRightInASentence) {
  start();
  serve_known_model(cell);
  const std::string address = notice().at("grpc_tls");
  const auto authority = certificates.path("authority.pem");
  const auto reason_of = [&](client::Credentials credentials) {
    const auto answer =
        client::Client(address, "eve", credentials).target({{"x_mm", 1.5}}, seconds(20));
    return answer ? std::string("it answered") : answer.error().reason;
  };
  EXPECT_EQ(reason_of({authority, "", "", ""}), "NO_IDENTITY");
  EXPECT_EQ(reason_of({authority, "", "", "dwt_wrong"}), "BAD_TOKEN");
  const auto viewer = token("vera", "viewer");
  EXPECT_EQ(reason_of({authority, "", "", text_of(viewer)}), "NEEDS_ROLE");
  EXPECT_EQ(reason_of({}), "NO_DAEMON") << "a plain client at a TLS door";
  EXPECT_EQ(reason_of({folder.path() + "/nowhere.pem", "", "", ""}), "BAD_CREDENTIALS");
  const TemporaryFolder elsewhere;
  const TestCertificates others(elsewhere.path());
  EXPECT_EQ(reason_of({others.path("authority.pem"), "", "", ""}), "NO_DAEMON")
      << "a daemon that this authority does not know";
  EXPECT_EQ(reason_of({authority, others.client("eve", "driftwise:role/admin").certificate,
                       others.path("eve-key.pem"), ""}),
            "NO_DAEMON")
      << "a certificate of another authority";
  wait_until("the failed handshake in the log", [&] {
    return cell.daemon_log().find("gRPC door: the TLS handshake with ipv4:127.0.0.1 failed: ") !=
           std::string::npos;
  });
  EXPECT_THAT(cell.daemon_log(), HasSubstr("access: eve from ipv4:127.0.0.1: a wrong token"));
  EXPECT_THAT(cell.daemon_log(), testing::Not(HasSubstr("dwt_wrong")));
  if (!has_grpcio()) GTEST_SKIP() << "python3-grpcio is not installed: Python was not asked";
  const auto refused = python({"--token-file", viewer, address, "x_mm=1.5"});
  EXPECT_EQ(refused.code, 5);
  EXPECT_THAT(refused.err, testing::AllOf(StartsWith("NEEDS_ROLE: "), HasSubstr("vera")));
}

TEST_F(SecuredDoors, LetAPythonFollowerComeBackAfterTheDaemonWasKilled) {
  if (!has_grpcio()) GTEST_SKIP() << "python3-grpcio is not installed";
  start();
  serve_known_model(cell);
  const std::string address = notice().at("grpc_tls");
  const auto stage = token("stage", "controller");
  // Says what changed for the follower and for who only asks. "away" comes after an attempt to
  // connect was refused: from then on calls fail at once.
  Process following(
      {"/usr/bin/python3", "-c",
       "import sys, time; sys.path.insert(0, sys.argv[1]); import driftwise\n"
       "cell = driftwise.Cell(sys.argv[2], ca=sys.argv[3], token_file=sys.argv[4])\n"
       "follower = cell.follow(x_mm=0.5)\n"
       "def now(ask):\n"
       "    try: return 'target' if ask().q_mm else ''\n"
       "    except driftwise.DriftwiseError as error:\n"
       "        return 'away' if 'refused' in str(error) else error.reason\n"
       "last = None\n"
       "while True:\n"
       "    both = {now(follower.latest), now(lambda: cell.target(x_mm=0.5))}\n"
       "    if both != last and both in ({'target'}, {'away'}): print(*both, flush=True)\n"
       "    last = both if both in ({'target'}, {'away'}) else last\n"
       "    time.sleep(0.02)\n",
       kClients + "/python", address, certificates.path("authority.pem"), stage},
      // gRPC's own poller would come after the test.
      {"PYTHONDONTWRITEBYTECODE=1", "GRPC_CLIENT_CHANNEL_BACKUP_POLL_INTERVAL_MS=600000"},
      cell.folder() + "/follower.log");
  EXPECT_EQ(following.read_line(minutes(1)), "target")
      << read_file(cell.folder() + "/follower.log");
  cell.kill_daemon();
  EXPECT_EQ(following.read_line(minutes(1)), "away");
  cell.edit_cell_file("listen = \"127.0.0.1:0\"\nloopback",
                      "listen = \"" + address + "\"\nloopback");
  cell.start_daemon();
  EXPECT_EQ(following.read_line(minutes(1)), "target") << "the token outlives the daemon";
}

TEST_F(SecuredDoors, StandPlainOnAnInterfaceForListedAddressesAndSaySoInStatus) {
  start(
      "plain_target_line = \"127.0.0.1:0\"\nplain_interface = \"lo\"\n"
      "plain_allow = [\"127.0.0.1\"]\n");
  EXPECT_THAT(ask_line(notice().at("target_line_plain"), "TARGET x_mm=1"), HasSubstr("NO_MODEL"))
      << "let in";
  EXPECT_THAT(cell.say({"status"}), HasSubstr("is not encrypted"));
}

TEST_F(SecuredDoors, AnswerOctaveByAToken) {
  const auto probe = run_process({"/usr/bin/octave-cli", "--quiet", "--no-init-file", "--eval",
                                  "pkg load instrument-control"});
  if (probe.code != 0)
    GTEST_SKIP() << "GNU Octave with its package instrument-control is not installed (apt install "
                    "octave octave-instrument-control)";
  start();
  serve_known_model(cell);
  const auto address = cell.target_line_address();
  const auto octave = run_process(
      {"/usr/bin/octave-cli", "--quiet", "--no-init-file", "--eval",
       "addpath('" + kClients + "/examples/matlab'); line = driftwise_line('127.0.0.1', " +
           address.substr(address.rfind(':') + 1) + ", '" + text_of(token("lab", "controller")) +
           "'); a = driftwise_target(line, 'x_mm', 1.5); printf('%.9f %s\\n', a.q1_mm, a.flags); "
           "try driftwise_target(line, 'y_mm', 1); catch err, disp(err.identifier), end"},
      minutes(2));
  ASSERT_EQ(octave.code, 0) << octave.err;
  EXPECT_THAT(octave.out,
              testing::MatchesRegex("1\\.[0-9]+ .*\n(.|\n)*driftwise:MISSING_COORDINATE\n"));
}

}  // namespace
}  // namespace driftwise::tests
