// driftwise audit: by the daemon and on a file, and what it says of a record that was changed.

#include "server/formats/text/kept_stop.h"
#include "storage/sqlite/database.h"
#include "tests/unit/cli/cli_fixture.h"

namespace driftwise::tests {
namespace {

class AuditCommands : public CliTest {
 protected:
  AuditCommands() { cell.add_points(cell.add_run(), 3); }
  std::string database() const { return cell.database(); }
};

TEST_F(AuditCommands, ListShowsWhoDidWhatWithTheValueBeforeAndAfter) {
  EXPECT_EQ(run({"note", "add", "--run", "1", "the door was open"}).exit, 0);
  const auto acts = json({"audit", "list"})["acts"];
  ASSERT_EQ(acts.size(), 1U);
  EXPECT_EQ(acts[0]["who"], "ada");
  EXPECT_EQ(acts[0]["proof"], "stated");
  EXPECT_EQ(acts[0]["what"], "note.added");
  EXPECT_EQ(acts[0]["subject"], "run 1");
  EXPECT_GT(acts[0]["event_id"], 0);
  EXPECT_EQ(json({"audit", "list", "--database", database()})["acts"], acts);
  EXPECT_THAT(run({"audit", "list"}).out, HasSubstr("note.added"));
}

TEST_F(AuditCommands, HeadIsTheSameByTheDaemonAndOfTheFile) {
  const auto head = run({"audit", "head"}).out;
  EXPECT_THAT(head, testing::MatchesRegex("[0-9a-f]+@[0-9]+\n"));
  EXPECT_EQ(run({"audit", "head", "--database", database()}).out, head);
}

TEST_F(AuditCommands, VerifyHoldsTheRecordAgainstItsChainAndAKeptHead) {
  const auto head = run({"audit", "head"}).out;
  const std::string kept = head.substr(0, head.size() - 1);
  EXPECT_EQ(run({"audit", "verify", "--head", kept}).exit, 0);
  const auto whole = run({"audit", "verify"});
  EXPECT_EQ(whole.exit, 0) << whole.out;
  EXPECT_THAT(whole.out, HasSubstr("the record is as it was stored"));

  storage::Database(database(), SQLITE_OPEN_READWRITE, "")
      .execute("UPDATE point SET line = line + 7 WHERE point_id = 2");
  for (const auto& arguments : {std::vector<std::string>{"audit", "verify"},
                                {"audit", "verify", "--database", database()}}) {
    const auto changed = run(arguments);
    EXPECT_EQ(changed.exit, 1);
    EXPECT_THAT(changed.out, HasSubstr("the record was changed"));
    EXPECT_THAT(changed.out, HasSubstr("point with point_id 2 differs"));
  }
}

TEST_F(AuditCommands, BackupIsRestoredElsewhereAndNeverOverARecord) {
  const auto copy = json({"backup"});
  EXPECT_EQ(copy["head"]["hash"].get<std::string>().size(), 64U);
  const std::string back = folder.path() + "/back.db";
  const auto restored = run({"restore", copy["path"], "--database", back});
  // A run of the copy, and what waits in its queue, begin again when a person says so; a cell whose
  // folder this is goes on.
  EXPECT_FALSE(std::filesystem::exists(folder.path() + "/driftwised.stop"));
  std::ifstream kept(formats::kept_stop_of_record(back));
  EXPECT_EQ(
      formats::read_kept_stop(std::string(std::istreambuf_iterator<char>(kept), {})).who,
      "the restore of " + std::filesystem::path(copy["path"]).filename().string() + " by ada");
  EXPECT_EQ(restored.exit, 0) << restored.err;
  EXPECT_THAT(restored.out, HasSubstr("restored " + back));
  EXPECT_EQ(run({"audit", "verify", "--database", back}).exit, 0);
  const auto again = run({"restore", copy["path"], "--database", back});
  EXPECT_EQ(again.exit, 3);
  EXPECT_THAT(again.err, HasSubstr("--replace"));
  EXPECT_EQ(run({"restore", copy["path"], "--database", back, "--replace", "--yes"}).exit, 0);
  const auto under_a_daemon =
      run({"restore", copy["path"], "--database", database(), "--replace", "--yes"});
  EXPECT_EQ(under_a_daemon.exit, 3);
  EXPECT_THAT(under_a_daemon.err, HasSubstr("database"));
}

TEST_F(AuditCommands, SayWhatIsWrongWithAHeadOrAFile) {
  const auto head = run({"audit", "verify", "--head", "deadbeef@3"});
  EXPECT_EQ(head.exit, 2);
  EXPECT_THAT(head.err, HasSubstr("expected HASH@N"));
  const auto file = run({"audit", "verify", "--database", folder.path() + "/none.db"});
  EXPECT_EQ(file.exit, 3);
  EXPECT_THAT(file.err, HasSubstr("none.db"));
}

}  // namespace
}  // namespace driftwise::tests
