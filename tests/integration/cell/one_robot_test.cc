// One robot, one daemon: a second one is refused by every other name of the database and of the
// controller, and motion from elsewhere is seen.

#include <gmock/gmock.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <filesystem>
#include <thread>

#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;

class OneRobot : public testing::Test {
 protected:
  // The cell's file once more in a folder of its own, with this put in place of that.
  std::string another_cell_file(const std::string& found, const std::string& instead) {
    const std::string folder = cell.folder() + "/other";
    std::filesystem::create_directories(folder);
    std::string text = read_file(cell.folder() + "/cell.toml");
    const auto at = text.find(found);
    EXPECT_NE(at, std::string::npos) << found;
    text.replace(at, found.size(), instead);
    // The clock that the two processes share stays where it is.
    if (const auto clock = text.find("file = \"clock"); clock != std::string::npos)
      text.insert(clock + 8, "../");
    write_file(folder + "/cell.toml", text);
    return folder + "/cell.toml";
  }
  Finished second_daemon(const std::string& cell_file) {
    return run_process({std::string(DRIFTWISE_BIN_DIR) + "/driftwised", "--cell", cell_file},
                       std::chrono::seconds(20));
  }
  std::string database_name() const {
    return std::filesystem::path(cell.database()).filename().string();
  }
  std::string pid() { return std::to_string(cell.daemon().pid()); }

  CellAtWork cell;
};

TEST_F(OneRobot, IsDrivenByOneDaemonWhateverTheDatabaseIsCalled) {
  cell.start_daemon();
  const auto same = second_daemon(cell.folder() + "/cell.toml");
  EXPECT_EQ(same.code, 5) << same.err;
  EXPECT_THAT(same.err, HasSubstr(pid()));
  // By a hard link: another name, another folder, the same file; and another controller, so that
  // the database alone decides.
  std::filesystem::create_directories(cell.folder() + "/other");
  std::filesystem::create_hard_link(cell.database(), cell.folder() + "/other/" + database_name());
  const auto linked = second_daemon(another_cell_file(cell.device_address("axis"), "127.0.0.1:1"));
  EXPECT_EQ(linked.code, 5) << linked.err;
  EXPECT_THAT(linked.err, HasSubstr("DATABASE_IN_USE"));
  EXPECT_THAT(linked.err, HasSubstr(pid()));
  for (const auto& entry : std::filesystem::recursive_directory_iterator(cell.folder()))
    EXPECT_NE(entry.path().extension(), ".lock") << "nothing to delete";
  EXPECT_EQ(cell.cli({"status"}).code, 0) << "the first one does not mind";
}

TEST_F(OneRobot, IsDrivenByOneDaemonWhateverTheControllerIsCalled) {
  cell.start_daemon();
  const std::string address = cell.device_address("axis");
  const std::string port = address.substr(address.rfind(':'));
  for (const std::string& name : {address, "localhost" + port}) {
    const auto refused = second_daemon(another_cell_file(address, name));
    EXPECT_EQ(refused.code, 5) << refused.err;
    EXPECT_THAT(refused.err, HasSubstr("CONTROLLER_IN_USE"));
    EXPECT_THAT(refused.err, HasSubstr(pid()));
  }
  // A check drives nothing.
  EXPECT_EQ(run_process({std::string(DRIFTWISE_BIN_DIR) + "/driftwised", "--check", "--cell",
                         cell.folder() + "/cell.toml"})
                .code,
            0);
}

TEST_F(OneRobot, IsNotCalledGoodByACheckWhereTheRecordHasNoPlace) {
  const auto file = another_cell_file("database = \"", "database = \"no_such_folder/");
  const auto checked =
      run_process({std::string(DRIFTWISE_BIN_DIR) + "/driftwised", "--check", "--cell", file});
  EXPECT_EQ(checked.code, 3);
  EXPECT_THAT(checked.err, HasSubstr("other/no_such_folder: No such file or directory"));
  EXPECT_EQ(second_daemon(file).code, 3) << "and a start is refused as well";
}

TEST_F(OneRobot, IsFreeAtOnceAfterAKill) {
  cell.start_daemon();
  cell.kill_daemon();
  EXPECT_NO_THROW(cell.start_daemon()) << cell.daemon_log();
}

TEST_F(OneRobot, MovedFromElsewherePausesTheRun) {
  cell.start_daemon();
  const auto run = cell.start_run(campaign(8, 6));
  cell.wait_for_points(8);
  const std::string address = cell.device_address("axis");
  boost::asio::io_context io;
  boost::asio::ip::tcp::socket other(io);
  other.connect({boost::asio::ip::make_address("127.0.0.1"),
                 static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)))});
  // Another computer drives the same controller, which takes whatever comes last.
  for (int i = 0; i < 200 && cell.state_of(run) != "paused"; ++i) {
    boost::asio::write(other, boost::asio::buffer(std::string("MOV X 0.5\n")));
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  wait_until("the run is paused", [&] { return cell.state_of(run) == "paused"; });
  EXPECT_EQ(cell.events("motion.uncommanded"), 1);
  wait_until("the alarm is on record", [&] {
    return cell.count("SELECT count(*) FROM alarm WHERE kind = 'motion.uncommanded'") == 1;
  });
  EXPECT_GE(cell.count("SELECT count(*) FROM attempt WHERE verdict = 'interrupted' AND reason LIKE "
                       "'%without a command%'"),
            1);
  other.close();
  cell.say({"run", "resume", std::to_string(run), "--yes"});
  EXPECT_EQ(cell.end_of(run).at("state"), "done");
  EXPECT_EQ(cell.count("SELECT count(*) FROM datum WHERE reason = 'uncommanded motion'"), 1);
}

}  // namespace
}  // namespace driftwise::tests
