// Alarms of a whole cell, to receivers that others wrote: Python's HTTP server, aiosmtpd, apprise.

#include <gmock/gmock.h>

#include <map>
#include <random>
#include <set>
#include <thread>

#include "tests/integration/cell/cell_at_work.h"
#include "tests/support/http_client.h"
#include "tests/unit/notify/receivers.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

class NotifyOnTheWire : public testing::Test {
 protected:
  void notify(const std::string& sections) const {
    cell.edit_cell_file("[run]", sections + "\n[run]");
  }
  static std::string webhook(const std::string& name, const std::string& url) {
    return "[[notify]]\nname = \"" + name + "\"\nwebhook = \"" + url + "\"\n";
  }
  // How often each state of each alarm was told: "firing device.lost scanner".
  static std::map<std::string, int> alerts(const std::vector<nlohmann::json>& bodies) {
    std::map<std::string, int> counts;
    for (const auto& body : bodies)
      for (const auto& alert : body.at("alerts"))
        ++counts[alert.at("status").get<std::string>() + " " +
                 alert.at("labels").at("alertname").get<std::string>() + " " +
                 alert.at("labels").at("subject").get<std::string>()];
    return counts;
  }
  TemporaryFolder folder;
  CellAtWork cell;
};

TEST_F(NotifyOnTheWire, AnAlarmThatWasNotDeliveredLeavesAfterAKill) {
  const HttpReceiver receiver(folder.path(), "duty", "500");
  notify(webhook("duty", receiver.url()));
  cell.start_daemon();
  cell.control("fault drop scanner for 3000 s");
  wait_until("the receiver has refused the alarm", [&] { return !receiver.kept().empty(); });
  cell.kill_daemon();
  receiver.become("ok");
  cell.start_daemon();
  wait_until("the alarm has left",
             [&] { return alerts(receiver.taken()).contains("firing device.lost scanner"); });
  wait_until("its end has left",
             [&] { return alerts(receiver.taken()).contains("resolved device.lost scanner"); });
  // Told is stored: another kill tells nothing again.
  wait_until("the store has it",
             [&] { return cell.count("SELECT count(*) FROM telling WHERE resolved_ns > 0") > 0; });
  cell.kill_daemon();
  cell.start_daemon();
  const auto said = cell.ask({"notify", "test", "duty"});
  EXPECT_EQ(said.at("answer"), "HTTP 200: kept");
  const auto counts = alerts(receiver.taken());
  EXPECT_EQ(counts.at("firing device.lost scanner"), 1);
  EXPECT_EQ(counts.at("resolved device.lost scanner"), 1);
  EXPECT_EQ(counts.at("firing notify.test duty"), 1);
}

// Kills while messages are on their way: the receiver takes a second for each.
TEST_F(NotifyOnTheWire, NoAlarmIsLostThroughTenKills) {
  const HttpReceiver receiver(folder.path(), "duty", "slow");
  notify(webhook("duty", receiver.url()));
  std::mt19937 random(20261122);
  for (int kill = 0; kill < 10; ++kill) {
    cell.start_daemon();
    cell.control("fault drop scanner for " + std::to_string(60 + random() % 240) + " s");
    std::this_thread::sleep_for(std::chrono::milliseconds(200 + random() % 1800));
    cell.kill_daemon();
  }
  cell.start_daemon();
  const auto missing = [&] {
    std::set<std::string> told;
    for (const auto& body : receiver.taken())
      for (const auto& alert : body.at("alerts"))
        if (alert.at("status") == "firing") told.insert(alert.at("annotations").value("alarm", ""));
    std::vector<std::int64_t> ids;
    for (std::int64_t id = 1; id <= cell.count("SELECT coalesce(max(alarm_id), 0) FROM alarm");
         ++id)
      if (!told.contains(std::to_string(id))) ids.push_back(id);
    return ids;
  };
  wait_until("every alarm of the record was told", [&] { return missing().empty(); });
  EXPECT_GT(cell.count("SELECT count(*) FROM alarm"), 0);
}

TEST_F(NotifyOnTheWire, ReceiversThatDoNotAnswerDelayNeitherTheCellNorTheOthers) {
  const HttpReceiver dead(folder.path(), "dead", "hang"), broken(folder.path(), "broken", "500"),
      slow(folder.path(), "slow", "slow"), good(folder.path(), "good", "ok");
  notify(webhook("dead", dead.url()) + webhook("away", "http://127.0.0.1:1/") +
         webhook("broken", broken.url()) + webhook("slow", slow.url()) +
         webhook("good", good.url()) +
         "[[notify]]\nname = \"asleep\"\ncommand = [\"sleep\", \"1000\"]\n");
  cell.start_daemon();
  const auto run = cell.start_run(campaign(2, 6));
  cell.control("fault drop scanner for 1000 s");
  const auto lost = [&](const HttpReceiver& receiver) {
    return alerts(receiver.taken()).contains("firing device.lost scanner");
  };
  wait_until("the good receiver has it", [&] { return lost(good); });
  wait_until("the slow one as well", [&] { return lost(slow); });
  // What hangs is under way still; the run goes on and ends.
  EXPECT_EQ(cell.end_of(run).at("state"), "done");
  HttpClient metrics(cell.http_address());
  const auto text = metrics.get("/metrics").body;
  const std::string name = "\ndriftwise_executor_longest_pause_seconds ";
  const auto at = text.find(name);
  ASSERT_NE(at, std::string::npos);
  EXPECT_LT(std::stod(text.substr(at + name.size())), 1.0);  // the alarm daemon.paused
  broken.become("ok");
  wait_until("the broken one has it, now that it is well", [&] { return lost(broken); });
  const auto list = cell.ask({"notify", "list"});
  EXPECT_THAT(list.at("receivers"), SizeIs(6));
  EXPECT_EQ(cell.stop_daemon(), 0);  // the calls that hang end with it
}

TEST_F(NotifyOnTheWire, OneMailPerIncidentNotPerConsequence) {
  const MailReceiver mail(folder.path());
  const HttpReceiver hook(folder.path(), "apprise", "ok");
  notify("[[notify]]\nname = \"mail\"\nsmtp = \"" + mail.url() +
         "\"\nfrom = \"cell@lab.example\"\nto = \"ada@lab.example\"\nkinds = [\"device.lost\", "
         "\"run.waiting\", \"channel.stale\"]\n[[notify]]\nname = \"apprise\"\ncommand = "
         "[\"apprise\", \"-t\", \"{title}\", \"-b\", \"{text}\", \"json://127.0.0.1:" +
         hook.port() + "/\"]\nkinds = [\"device.lost\"]\n");
  cell.start_daemon();
  const auto run = cell.start_run(campaign(1, 6));
  cell.wait_for_points(1);
  cell.control("fault drop laser-x for 2000 s");  // the run waits meanwhile: a consequence
  wait_until("the mail of the alarm", [&] { return !mail.kept().empty(); });
  EXPECT_EQ(cell.end_of(run).at("state"), "done");
  wait_until("the mail of its end", [&] { return mail.kept().size() >= 2; });
  const auto mails = mail.kept();
  ASSERT_THAT(mails, SizeIs(2)) << nlohmann::json(mails).dump(1);
  EXPECT_THAT(mails[0].at("subject").get<std::string>(), HasSubstr("high: laser-x at "));
  EXPECT_THAT(mails[1].at("subject").get<std::string>(), HasSubstr("over: laser-x at "));
  EXPECT_EQ(mails[0].at("to"), nlohmann::json{"ada@lab.example"});
  wait_until("apprise has delivered it", [&] { return !hook.taken().empty(); });
  EXPECT_THAT(hook.taken()[0].at("title").get<std::string>(), HasSubstr("high: laser-x at "));
}

TEST_F(NotifyOnTheWire, AnAlarmIsShelvedFromTheCommandLine) {
  notify(
      "[[channel_alarm]]\nchannel = \"t01_degC\"\nabove = -40.0\npriority = \"high\"\nsentence = "
      "\"this test wants it\"\n");
  cell.start_daemon();
  const auto standing = [&]() -> nlohmann::json {
    for (const auto& alarm : cell.ask({"alarms"}).value("alarms", nlohmann::json::array()))
      if (alarm.at("kind") == "channel.limit") return alarm;
    return {};
  };
  wait_until("the limit's alarm", [&] { return !standing().is_null(); });
  EXPECT_THAT(standing().at("message").get<std::string>(), HasSubstr("this test wants it"));
  const std::string id =
      std::to_string(cell.count("SELECT alarm_id FROM alarm WHERE kind = 'channel.limit'"));
  EXPECT_EQ(cell.cli({"alarms", "shelve", id, "--for", "3w", "--reason", "x"}).code, 2);
  EXPECT_THAT(cell.say({"alarms", "shelve", id, "--for", "2h", "--reason", "the door is open"}),
              HasSubstr("the door is open"));
  EXPECT_FALSE(standing().value("shelved_until_time", "").empty());
  EXPECT_THAT(cell.say({"alarms", "unshelve", id}), HasSubstr("not acknowledged"));
  EXPECT_EQ(cell.count("SELECT count(*) FROM audit WHERE what LIKE 'alarm.%shelved'"), 2);
}

}  // namespace
}  // namespace driftwise::tests
