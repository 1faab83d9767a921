// The file of heads: every one stays, over restarts and cut-off lines.

#include "server/watchdog/heads_log.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>

#include "tests/support/process.h"

namespace driftwise::watchdog {
namespace {

ChainHead head(std::int64_t entry, char digit) { return {entry, std::string(64, digit)}; }
constexpr UtcTime kAt{1'795'248'000'000'000'000};

class HeadsLogTest : public testing::Test {
 protected:
  tests::TemporaryFolder folder;
  std::string path = folder.path() + "/heads.log";
};

TEST_F(HeadsLogTest, KeepsEveryHeadWithItsInstantAndItsCell) {
  {
    auto log = HeadsLog::open(path).value();
    EXPECT_TRUE(log.keep("cell a", kAt, head(1, 'a')));
    EXPECT_TRUE(log.keep("cell a", kAt, head(1, 'a')));  // told again
    EXPECT_TRUE(log.keep("cell a", kAt, head(2, 'b')));
    EXPECT_TRUE(log.keep("b", kAt, ChainHead{}));  // a record without a chain
  }
  EXPECT_EQ(tests::read_file(path), "2026-11-21T08:00:00Z " + std::string(64, 'a') +
                                        "@1 cell a\n2026-11-21T08:00:00Z " + std::string(64, 'b') +
                                        "@2 cell a\n");
  struct stat state {};
  ASSERT_EQ(::stat(path.c_str(), &state), 0);
  EXPECT_EQ(state.st_mode & 0777, 0600U);
  const auto log = HeadsLog::open(path).value();
  ASSERT_EQ(log.newest().size(), 1U);
  EXPECT_EQ(log.newest().at("cell a").head, head(2, 'b'));
}

TEST_F(HeadsLogTest, ALineThatWasCutOffCostsNoOther) {
  tests::write_file(
      path, "2026-11-21T08:00:00Z " + std::string(64, 'a') + "@1 a\n2026-11-21T08:00:00Z aaaa");
  auto log = HeadsLog::open(path).value();
  EXPECT_EQ(log.newest().at("a").head, head(1, 'a'));
  EXPECT_TRUE(log.keep("a", kAt, head(2, 'b')));
  EXPECT_EQ(HeadsLog::open(path).value().newest().at("a").head, head(2, 'b'));
}

TEST_F(HeadsLogTest, ALineThatWasCutOffWithinItsNameIsNoCell) {
  const std::string one = "2026-11-21T08:00:00Z " + std::string(64, 'a') + "@3 cell-a";
  tests::write_file(path, one + "\n" + one.substr(0, one.size() - 3));
  {
    auto log = HeadsLog::open(path).value();
    EXPECT_EQ(log.newest().size(), 1U) << "a cell 'cel' would be missed for ever";
    EXPECT_TRUE(log.keep("cell-a", kAt, head(4, 'b')));
  }
  const auto again = HeadsLog::open(path).value();
  ASSERT_EQ(again.newest().size(), 1U) << tests::read_file(path);
  EXPECT_EQ(again.newest().at("cell-a").head, head(4, 'b'));
}

// A full disk takes a part of a line; the limit of a file's size does the same.
TEST_F(HeadsLogTest, ALineThatWasWrittenInPartIsEndedBeforeTheNext) {
  auto log = HeadsLog::open(path).value();
  ASSERT_TRUE(log.keep("cell-a", kAt, head(3, 'a')));
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit tight{tests::read_file(path).size() + 91, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &tight), 0);
  const auto refused = log.keep("cell-b", kAt, head(5, 'b'));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "DISK_FULL");
  EXPECT_TRUE(log.keep("cell-a", kAt, head(6, 'c')));
  const auto again = HeadsLog::open(path).value();
  ASSERT_EQ(again.newest().size(), 1U) << tests::read_file(path);
  EXPECT_EQ(again.newest().at("cell-a").head, head(6, 'c'));
}

TEST_F(HeadsLogTest, AFileThatCannotBeWrittenIsNamed) {
  EXPECT_EQ(HeadsLog::open(folder.path() + "/no/heads.log").error().reason, "CANNOT_OPEN");
}

}  // namespace
}  // namespace driftwise::watchdog
