// driftwise watchdog beside a whole cell: silence, its end, and a record whose chain was computed
// anew.

#include <gmock/gmock.h>
#include <signal.h>

#include <fstream>
#include <sstream>

#include "tests/integration/cell/cell_at_work.h"
#include "tests/unit/notify/receivers.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

class WatchdogBesideACell : public testing::Test {
 protected:
  WatchdogBesideACell()
      : watchdog({DRIFTWISE_BIN_DIR "/driftwise", "watchdog", "--listen", "127.0.0.1:0",
                  "--silent-after", "3", "--heads", heads, "--webhook", receiver.url()},
                 {}, log) {
    const std::string before = "waits for signs of life at ";
    wait_until("the watchdog listens",
               [&] { return text_of(log).find(before) != std::string::npos; });
    const std::string text = text_of(log);
    const auto begin = text.find(before) + before.size();
    cell.edit_cell_file("[run]", "[watchdog]\nurl = \"http://" +
                                     text.substr(begin, text.find(';') - begin) +
                                     "/\"\nevery_s = 1\n\n[run]");
  }
  static std::string text_of(const std::string& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  bool told(const std::string& status, const std::string& kind) const {
    for (const auto& body : receiver.taken())
      for (const auto& alert : body.at("alerts"))
        if (alert.at("status") == status && alert.at("labels").at("alertname") == kind) return true;
    return false;
  }
  // HASH@N of the last line.
  std::string kept_head() const {
    const std::string text = text_of(heads);
    const auto begin = text.rfind('\n', text.size() - 2) + 1;
    std::istringstream words(text.substr(begin));
    std::string at, head;
    words >> at >> head;
    return head;
  }

  TemporaryFolder folder;
  std::string heads = folder.path() + "/heads.log", log = folder.path() + "/watchdog.log";
  HttpReceiver receiver{folder.path(), "duty", "ok"};
  Process watchdog;
  CellAtWork cell;
};

TEST_F(WatchdogBesideACell, RaisesSilenceAndFindsAChainThatWasComputedAnew) {
  cell.start_daemon();
  wait_until("a head is kept", [&] { return text_of(heads).find('@') != std::string::npos; });
  cell.kill_daemon();
  wait_until("the silence is told", [&] { return told("firing", "cell.silent"); });
  const std::string kept = kept_head();

  // Somebody who owns the file changes an event, and lets a chain be computed over the result.
  const auto changed =
      run_process({"/usr/bin/sqlite3", cell.database(),
                   "UPDATE event SET detail = 'nothing happened' WHERE event_id = 1; DELETE FROM "
                   "chain;"});
  ASSERT_EQ(changed.code, 0) << changed.err;
  cell.start_daemon();
  wait_until("the end of the silence is told", [&] { return told("resolved", "cell.silent"); });
  EXPECT_EQ(cell.cli({"audit", "verify"}).code, 0);  // by itself it looks whole
  const auto found = cell.cli({"audit", "verify", "--head", kept});
  EXPECT_EQ(found.code, 1) << found.out << found.err;
  EXPECT_THAT(found.out, HasSubstr("head"));

  watchdog.signal(SIGTERM);
  EXPECT_EQ(watchdog.wait(std::chrono::seconds(20)), 130);
}

}  // namespace
}  // namespace driftwise::tests
