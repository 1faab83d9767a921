// The daemon across a network: a second network namespace that the test makes, with the command
// line, a browser, a Python controller and the text line in it, TLS, every role. Where the kernel
// gives no namespace the same runs over a second loopback address, and says so.

#include <gmock/gmock.h>

#include <filesystem>
#include <map>
#include <thread>

#include "tests/integration/cell/cell_at_work.h"
#include "tests/integration/cell/served_model.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

const std::string kSource = DRIFTWISE_SOURCE_DIR, kPage = kSource + "/clients/web/dist";
const std::string kProgram = std::string(DRIFTWISE_BIN_DIR) + "/driftwise";

// True once the process has a network namespace of its own.
bool left_our_network(Process& process) {
  const std::string pid = std::to_string(process.pid());
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  std::error_code gone;
  const auto ours = std::filesystem::read_symlink("/proc/self/ns/net", gone);
  while (std::chrono::steady_clock::now() < until) {
    const auto theirs = std::filesystem::read_symlink("/proc/" + pid + "/ns/net", gone);
    if (!gone && theirs != ours) return true;
    if (!process.running()) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

// Another computer, as far as the kernel is concerned.
class OtherHost {
 public:
  OtherHost() {
    const std::string id = std::to_string(getpid() % 100'000);
    const std::string here = "dw" + id + "a", there = "dw" + id + "b";
    try {
      sleeper_ = std::make_unique<Process>(
          std::vector<std::string>{"/usr/bin/unshare", "-n", "/usr/bin/sleep", "600"});
    } catch (const std::exception& refused) {
      why_not_ = refused.what();
      return;
    }
    const std::string pid = std::to_string(sleeper_->pid());
    if (!left_our_network(*sleeper_)) {
      why_not_ = "unshare gave no network of its own";
      return;
    }
    const std::vector<std::vector<std::string>> steps = {
        {"ip", "link", "add", here, "type", "veth", "peer", "name", there, "netns", pid},
        {"ip", "addr", "add", std::string(kHere) + "/30", "dev", here},
        {"ip", "link", "set", here, "up"},
        {"nsenter", "-t", pid, "-n", "ip", "addr", "add", std::string(kThere) + "/30", "dev",
         there},
        {"nsenter", "-t", pid, "-n", "ip", "link", "set", there, "up"}};
    for (auto step : steps) {
      step.insert(step.begin(), "/usr/bin/env");
      const auto done = run_process(step, std::chrono::seconds(10));
      if (done.code != 0) {
        why_not_ = done.err;
        return;
      }
    }
  }
  // Its interfaces go with its last process.

  bool there() const { return why_not_.empty(); }
  const std::string& why_not() const { return why_not_; }
  // The address of the daemon as seen from there.
  std::string daemon() const { return there() ? kHere : "127.0.0.2"; }
  std::string own() const { return there() ? kThere : "127.0.0.1"; }
  std::vector<std::string> prefix() const {
    if (!there()) return {};
    return {"/usr/bin/nsenter", "-t", std::to_string(sleeper_->pid()), "-n"};
  }

 private:
  static constexpr const char* kHere = "10.77.199.1";
  static constexpr const char* kThere = "10.77.199.2";
  std::unique_ptr<Process> sleeper_;
  std::string why_not_;
};

class AcrossTheNetwork : public testing::Test {
 protected:
  void SetUp() override {
    if (!other.there())
      std::printf("NO NETWORK NAMESPACE (%s): over two loopback addresses instead\n",
                  other.why_not().c_str());
    ASSERT_EQ(here({"cert", "init", "--name", "10.77.199.1", "--name", "127.0.0.2"}).code, 0);
    for (const std::string role : {"viewer", "controller", "operator", "engineer", "admin"})
      ASSERT_EQ(here({"cert", "client", role + "-1", "--role", role}).code, 0);
    std::string text = read_file(cell.folder() + "/cell.toml");
    write_file(cell.folder() + "/cell.toml",
               text +
                   "\n[access]\nlisten = \"0.0.0.0:0\"\ncertificate = \"tls/server.pem\"\n"
                   "key = \"tls/server.key\"\nauthority = \"tls/authority.pem\"\n"
                   "revoked = \"tls/revoked.pem\"\nhttp = \"0.0.0.0:0\"\n"
                   "target_line = \"0.0.0.0:0\"\n" +
                   (fs::exists(kPage + "/index.html") ? "[web]\nroot = \"" + kPage + "\"\n" : ""));
    cell.start_daemon();
    server = from_there("grpc_tls");
  }
  // The address of a door as the other computer reaches it.
  std::string from_there(const std::string& door) const {
    std::string address = notice().at(door);
    while (address.ends_with('/')) address.pop_back();
    return other.daemon() + address.substr(address.rfind(':'));
  }
  // A token of each role, in tls/ROLE.token.
  void make_tokens() const {
    for (const std::string role : {"viewer", "controller", "operator", "engineer", "admin"})
      ASSERT_EQ(
          here({"token", "create", role + "-page", "--role", role, "-o", "tls/" + role + ".token"})
              .code,
          0);
  }
  // Acts that were refused, as the audit has them.
  nlohmann::json refusals() const {
    nlohmann::json out = nlohmann::json::array();
    const auto acts =
        nlohmann::json::parse(here({"audit", "list", "--limit", "1000", "--json"}).out);
    for (const auto& act : acts.at("acts"))
      if (act.at("what") == "access.refused") out.push_back(act);
    return out;
  }

  nlohmann::json notice() const {
    return nlohmann::json::parse(read_file(cell.folder() + "/driftwised.json"));
  }
  // The command line beside the cell file, without being told where the daemon is.
  Finished here(std::vector<std::string> arguments) const { return run({}, std::move(arguments)); }
  // On the other computer.
  Finished there(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--server", server, "--timeout", "10"});
    return run(other.prefix(), std::move(arguments));
  }
  Finished as(const std::string& name, std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(),
                     {"--tls-ca", "tls/authority.pem", "--tls-cert", "tls/" + name + ".pem",
                      "--tls-key", "tls/" + name + ".key"});
    return there(std::move(arguments));
  }
  Finished run(std::vector<std::string> command, std::vector<std::string> arguments) const {
    command.insert(command.end(), {"/usr/bin/env", "-C", cell.folder(), "NO_COLOR=1", kProgram});
    command.insert(command.end(), arguments.begin(), arguments.end());
    return run_process(command);
  }

  OtherHost other;
  CellAtWork cell;
  std::string server;
};

TEST_F(AcrossTheNetwork, EachRoleDoesWhatItMayAndIsRefusedTheRest) {
  const std::vector<std::string> roles = {"viewer", "controller", "operator", "engineer", "admin"};
  struct Deed {
    std::vector<std::string> arguments;
    std::size_t from;  // the lowest role, by its place above
    std::string needs;
  };
  const std::vector<Deed> deeds = {{{"status"}, 0, "viewer"},
                                   {{"stop"}, 0, "viewer"},
                                   {{"target", "x=1"}, 1, "controller"},
                                   {{"note", "add", "--run", "1", "hello"}, 2, "operator"},
                                   {{"fit", "--run", "1", "--model", "q ~ x"}, 3, "engineer"},
                                   {{"token", "list"}, 4, "admin"}};
  int allowed = 0, refused = 0;
  for (std::size_t role = 0; role < roles.size(); ++role) {
    const auto who = as(roles[role] + "-1", {"whoami"});
    ASSERT_EQ(who.code, 0) << who.err;
    EXPECT_THAT(who.out, HasSubstr(roles[role] + "-1, " + roles[role] +
                                   ", by certificate, from "
                                   "ipv4:" +
                                   other.own() + ":"));
    for (const auto& deed : deeds) {
      const auto done = as(roles[role] + "-1", deed.arguments);
      const std::string what = roles[role] + " " + deed.arguments[0] + ": " + done.err;
      if (role >= deed.from) {
        ++allowed;
        EXPECT_THAT(done.err, Not(HasSubstr("needs the role"))) << what;
        EXPECT_NE(done.code, 4) << what;
        if (deed.from == 0) {
          EXPECT_EQ(done.code, 0) << what;
        }
      } else {
        ++refused;
        EXPECT_EQ(done.code, 5) << what;
        EXPECT_THAT(done.err, HasSubstr("it needs the role " + deed.needs)) << what;
      }
    }
  }
  std::printf("%d deeds allowed, %d refused, %s\n", allowed, refused,
              other.there() ? "from a second network namespace" : "from a second address");
  const auto events = here({"events"});
  EXPECT_THAT(events.out, HasSubstr("access.refused"));
  EXPECT_THAT(events.out, HasSubstr("viewer-1 (certificate, viewer, from ipv4:" + other.own()));
  wait_until("the refusals in the audit",
             [&] { return refusals().size() == static_cast<std::size_t>(refused); });
  for (const auto& act : refusals()) {
    EXPECT_EQ(act.at("proof"), "certificate");
    EXPECT_THAT(act.at("from").get<std::string>(), testing::StartsWith("ipv4:" + other.own()));
    EXPECT_THAT(act.at("outcome").get<std::string>(),
                testing::AllOf(testing::StartsWith("refused: " + act.at("who").get<std::string>()),
                               HasSubstr("it needs the role")));
    EXPECT_THAT(act.at("subject").get<std::string>(),
                testing::AnyOf("ComputeTarget", "CreateNote", "CreateFit", "ListTokens"));
  }
  EXPECT_EQ(here({"audit", "verify"}).code, 0);
}

TEST_F(AcrossTheNetwork, ThePageAPythonControllerAndTheLineDoWhatTheirRoleMay) {
  if (run_process({"/usr/bin/python3", "-c", "import grpc, google.protobuf"}).code != 0)
    GTEST_SKIP() << "python3-grpcio is not installed";
  // Loopback is open for what this test itself asks; the doors with TLS are as ever.
  ASSERT_EQ(cell.stop_daemon(), 0);
  cell.edit_cell_file("[access]\n", "[access]\nloopback = \"open\"\n");
  cell.start_daemon();
  server = from_there("grpc_tls");
  serve_known_model(cell);
  make_tokens();
  auto words = other.prefix();
  words.insert(words.end(),
               {"/usr/bin/python3", kSource + "/tests/integration/cell/peers/across_roles.py",
                kSource + "/clients/python", cell.folder() + "/tls", server, from_there("web_tls"),
                from_there("target_line_tls")});
  const auto done = run_process(words, std::chrono::minutes(2), {"PYTHONDONTWRITEBYTECODE=1"});
  ASSERT_EQ(done.code, 0) << done.err;
  const auto said = nlohmann::json::parse(done.out);
  std::printf("%zu acts allowed, %zu refused, %s\n", said.at("allowed").size(),
              said.at("refused").size(),
              other.there() ? "from a second network namespace" : "from a second address");
  ASSERT_EQ(said.at("refused").size(), 12U);
  wait_until("the refusals in the audit", [&] { return refusals().size() == 12; });
  auto acts = refusals();
  for (const auto& one : said.at("refused")) {
    const bool page = one.at("door") == "page";
    const std::string who = one.at("role").get<std::string>() + (page ? "-page" : "-1");
    const auto at = std::find_if(acts.begin(), acts.end(), [&](const auto& act) {
      return act.at("who") == who && act.at("subject") == one.at("act") &&
             act.at("proof").template get<std::string>().starts_with(page ? "page session"
                                                                          : "certificate");
    });
    ASSERT_NE(at, acts.end()) << one << " is not in the audit: " << acts;
    EXPECT_THAT(at->at("from").get<std::string>(), HasSubstr(other.own()));
    EXPECT_THAT(one.at("sentence").get<std::string>(), HasSubstr("it needs the role"));
    acts.erase(at);
  }
}

TEST_F(AcrossTheNetwork, ARealBrowserLogsInWithEachRoleAndIsRefusedInASentence) {
  make_tokens();
  const std::string script = kSource + "/tests/browser/across.mjs";
  auto words = other.prefix();
  words.insert(words.end(),
               {"/usr/bin/env", "DRIFTWISE_BIN_DIR=" + std::string(DRIFTWISE_BIN_DIR), "node",
                script, "https://" + from_there("web_tls"), cell.folder() + "/tls"});
  const auto done = run_process(words, std::chrono::minutes(2));
  if (done.code == 127) GTEST_SKIP() << "no node (Debian: nodejs npm)";
  if (done.out.find("SKIPPED:") != std::string::npos) GTEST_SKIP() << done.out;
  ASSERT_EQ(done.code, 0) << done.out << done.err;
  std::printf("%s", done.out.c_str());
  wait_until("the refusals in the audit", [&] { return refusals().size() == 4; });
  std::map<std::string, std::string> acts;
  for (const auto& act : refusals()) {
    acts[act.at("who")] = act.at("subject");
    EXPECT_THAT(act.at("from").get<std::string>(), HasSubstr(other.own()));
  }
  EXPECT_THAT(acts, testing::UnorderedElementsAre(std::pair{"viewer-page", "Home"},
                                                  std::pair{"controller-page", "Home"},
                                                  std::pair{"operator-page", "PromoteModel"},
                                                  std::pair{"engineer-page", "ListTokens"}));
}

// At most 20 of one address and minute stand by themselves; the next one counts the others.
TEST_F(AcrossTheNetwork, RefusalsInTheAuditAreBounded) {
  make_tokens();
  const auto before = cell.count("SELECT count(*) FROM audit WHERE what = 'access.refused'");
  auto words = other.prefix();
  words.insert(
      words.end(),
      {"/usr/bin/python3", "-c",
       "import sys; sys.path.insert(0, sys.argv[1]); import driftwise\n"
       "with driftwise.Cell(sys.argv[2], ca=sys.argv[3], token_file=sys.argv[4]) as cell:\n"
       "    for _ in range(60):\n"
       "        try: cell.target(x_mm=1, timeout_s=20)\n"
       "        except driftwise.DriftwiseError as error: assert error.reason == "
       "'NEEDS_ROLE'\n",
       kSource + "/clients/python", server, cell.folder() + "/tls/authority.pem",
       cell.folder() + "/tls/viewer.token"});
  const auto done = run_process(words, std::chrono::minutes(2), {"PYTHONDONTWRITEBYTECODE=1"});
  ASSERT_EQ(done.code, 0) << done.err;
  wait_until("the refusals", [&] { return refusals().size() >= 20; });
  EXPECT_EQ(before, 0);
  EXPECT_LE(refusals().size(), 21U) << "a minute may have ended between";
}

TEST_F(AcrossTheNetwork, ARevokedCertificateOpensNoDoorWithoutARestart) {
  ASSERT_EQ(as("controller-1", {"whoami"}).code, 0);
  auto line = other.prefix();
  line.insert(line.end(),
              {"/usr/bin/python3", "-c",
               "import socket, ssl, sys\n"
               "folder, host, port = sys.argv[1], *sys.argv[2].rsplit(':', 1)\n"
               "tls = ssl.create_default_context(cafile=folder + '/authority.pem')\n"
               "tls.load_cert_chain(folder + '/controller-1.pem', folder + '/controller-1.key')\n"
               "line = tls.wrap_socket(socket.create_connection((host, int(port))), "
               "server_hostname=host)\n"
               "file = line.makefile('rw', encoding='utf-8')\n"
               "for order in sys.stdin:\n"
               "    file.write('TARGET x_mm=1\\n'); file.flush()\n"
               "    print(file.readline().strip(), flush=True)\n",
               cell.folder() + "/tls", from_there("target_line_tls")});
  // The line is asked before, and by a new connection afterwards.
  const auto ask_once = [&] {
    auto words = line;
    words.insert(words.begin(), {"/bin/sh", "-c", "echo ask | \"$@\"", "sh"});
    return run_process(words).out;
  };
  EXPECT_THAT(ask_once(), HasSubstr("NO_MODEL")) << "let in";
  const auto revoked = here({"cert", "revoke", "controller-1"});
  ASSERT_EQ(revoked.code, 0) << revoked.err;
  EXPECT_THAT(revoked.out, HasSubstr("1 certificate revoked now"));
  Finished after;
  wait_until("the revocation", [&] {
    after = as("controller-1", {"whoami"});
    return after.code != 0;
  });
  EXPECT_EQ(after.code, 5);
  EXPECT_THAT(after.err, HasSubstr("was revoked"));
  wait_until("the revocation on the line",
             [&] { return ask_once().find("CERTIFICATE_REVOKED") != std::string::npos; });
  EXPECT_EQ(as("viewer-1", {"whoami"}).code, 0) << "others are not touched";
  EXPECT_THAT(here({"cert", "revoke", "controller-1"}).out, HasSubstr("1 before"));
  ASSERT_EQ(here({"cert", "client", "controller-1", "--role", "controller"}).code, 0);
  EXPECT_EQ(as("controller-1", {"whoami"}).code, 0) << "a new one of the same name";
  EXPECT_THAT(here({"audit", "list", "--json"}).out, HasSubstr("which was revoked"));
}

TEST_F(AcrossTheNetwork, NobodyIsLetInWithoutAnIdentity) {
  const auto unnamed = there({"--tls-ca", "tls/authority.pem", "status"});
  EXPECT_EQ(unnamed.code, 5);
  EXPECT_THAT(unnamed.err, HasSubstr("--tls-cert"));
  EXPECT_EQ(there({"status"}).code, 4) << "plain words to a door with TLS";
  // Somebody else's authority, on either side.
  ASSERT_EQ(here({"cert", "init", "--folder", "foreign"}).code, 0);
  ASSERT_EQ(here({"cert", "client", "eve", "--role", "admin", "--folder", "foreign"}).code, 0);
  EXPECT_EQ(there({"--tls-ca", "foreign/authority.pem", "status"}).code, 4);
  const auto eve = there({"--tls-ca", "tls/authority.pem", "--tls-cert", "foreign/eve.pem",
                          "--tls-key", "foreign/eve.key", "status"});
  EXPECT_EQ(eve.code, 4) << eve.out;
  // The daemon's own certificate is no client's.
  const auto server_as_client = there({"--tls-ca", "tls/authority.pem", "--tls-cert",
                                       "tls/server.pem", "--tls-key", "tls/server.key", "status"});
  EXPECT_NE(server_as_client.code, 0);
  // The plain door on loopback gives nothing by itself; socket and token file do.
  const std::string plain = notice().at("grpc");
  const auto loopback = run_process({kProgram, "status", "--server", plain});
  EXPECT_EQ(loopback.code, 5);
  EXPECT_THAT(loopback.err, HasSubstr("asks for a token"));
  const std::string token_file = notice().at("token_file");
  EXPECT_EQ(run_process({kProgram, "status", "--server", plain, "--token-file", token_file}).code,
            0);
  const auto local = here({"whoami"});
  EXPECT_THAT(local.out, HasSubstr("admin, by local socket"));
}

TEST_F(AcrossTheNetwork, ATokenOpensTheDoorUntilItIsRevoked) {
  const auto made = as("admin-1", {"token", "create", "press", "--role", "controller", "-o",
                                   "press.token", "--json"});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_EQ(made.out.find("dwt_"), std::string::npos) << "the text is in the file only";
  EXPECT_EQ(fs::status(cell.folder() + "/press.token").permissions(),
            fs::perms::owner_read | fs::perms::owner_write);
  const auto press = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(),
                     {"--tls-ca", "tls/authority.pem", "--token-file", "press.token"});
    return there(std::move(arguments));
  };
  const auto who = press({"whoami"});
  ASSERT_EQ(who.code, 0) << who.err;
  EXPECT_THAT(who.out, HasSubstr("press, controller, by token"));
  EXPECT_EQ(press({"stop"}).code, 0);
  EXPECT_EQ(press({"token", "list"}).code, 5);
  const std::string id = nlohmann::json::parse(made.out).at("token").at("id");
  EXPECT_EQ(here({"token", "revoke", id}).code, 0);
  const auto after = press({"whoami"});
  EXPECT_EQ(after.code, 5);
  EXPECT_THAT(after.err, HasSubstr("revoked"));
  for (int i = 0; i < 8; ++i) press({"whoami"});
  EXPECT_THAT(press({"whoami"}).err, HasSubstr("too many wrong tokens"));
  EXPECT_EQ(as("viewer-1", {"status"}).code, 0) << "a certificate from there is not slowed";
  EXPECT_THAT(here({"events"}).out, HasSubstr("access.locked"));
}

TEST_F(AcrossTheNetwork, ANewCertificateIsInForceWithoutARestart) {
  ASSERT_EQ(as("viewer-1", {"status"}).code, 0);
  const int pid = cell.daemon().pid();
  fs::copy(cell.folder() + "/tls", cell.folder() + "/old", fs::copy_options::recursive);
  for (const char* part : {"key", "pem"})
    fs::remove(cell.folder() + "/tls/authority." + part);  // another one is made
  ASSERT_EQ(here({"cert", "init", "--name", "10.77.199.1", "--name", "127.0.0.2"}).code, 0);
  ASSERT_EQ(here({"cert", "client", "viewer-1", "--role", "viewer"}).code, 0);
  Finished with_new;
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  do with_new = as("viewer-1", {"status"});
  while (with_new.code != 0 && std::chrono::steady_clock::now() < until);
  EXPECT_EQ(with_new.code, 0) << with_new.err;
  const auto with_old = there({"--tls-ca", "old/authority.pem", "--tls-cert", "old/viewer-1.pem",
                               "--tls-key", "old/viewer-1.key", "status"});
  EXPECT_EQ(with_old.code, 4) << "the old authority counts no longer";
  EXPECT_EQ(cell.daemon().pid(), pid);
}

TEST_F(AcrossTheNetwork, ACertificateThatEndsSoonIsAnAlarm) {
  EXPECT_EQ(here({"alarms", "--json"}).out.find("certificate.ends"), std::string::npos);
  ASSERT_EQ(here({"cert", "init", "--days", "20", "--name", "127.0.0.2"}).code, 0);
  ASSERT_EQ(cell.stop_daemon(), 0);
  cell.start_daemon();
  wait_until("the alarm", [&] {
    return here({"alarms", "--json"}).out.find("certificate.ends") != std::string::npos;
  });
  EXPECT_THAT(here({"alarms"}).out, HasSubstr("no restart is needed"));
}

TEST(DoorOutside, IsRefusedAtStartWithoutTls) {
  CellAtWork cell;
  const auto check = [&](const std::string& found, const std::string& instead) {
    cell.edit_cell_file(found, instead);
    auto said = run_process(
        {std::string(DRIFTWISE_BIN_DIR) + "/driftwised", "--cell", cell.folder() + "/cell.toml"},
        std::chrono::seconds(20));
    cell.edit_cell_file(instead, found);
    return said;
  };
  const auto plain = check("listen = \"127.0.0.1:0\"", "listen = \"0.0.0.0:0\"");
  EXPECT_EQ(plain.code, 3) << plain.err;
  EXPECT_THAT(plain.err, HasSubstr("needs TLS"));
  const auto access = check("[cell]", "[access]\nlisten = \"0.0.0.0:0\"\n[cell]");
  EXPECT_EQ(access.code, 3) << access.err;
  EXPECT_THAT(access.err, HasSubstr("NEEDS_TLS"));
}

}  // namespace
}  // namespace driftwise::tests
