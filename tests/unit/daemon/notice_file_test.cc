// driftwised.json on a disk that takes nothing for a while.

#include "server/notice_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <optional>
#include <stdexcept>

#include "tests/support/process.h"

namespace driftwise {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

// While it lives no file of this process grows beyond so many bytes: as on a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    if (::getrlimit(RLIMIT_FSIZE, &before_) != 0) throw std::runtime_error("getrlimit");
    const rlimit tight{bytes, before_.rlim_max};
    if (::setrlimit(RLIMIT_FSIZE, &tight) != 0) throw std::runtime_error("setrlimit");
  }
  ~FullDisk() { ::setrlimit(RLIMIT_FSIZE, &before_); }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
};

class NoticeFileTest : public testing::Test {
 protected:
  std::size_t files() const {
    std::size_t count = 0;
    for (const auto& one : fs::directory_iterator(folder.path())) count += !one.path().empty();
    return count;
  }
  const tests::TemporaryFolder folder;
  const std::string cell = folder.path() + "/cell.toml", path = folder.path() + "/driftwised.json";
  const std::string content = "{\n  \"grpc\": \"127.0.0.1:50051\"\n}\n";
};

TEST_F(NoticeFileTest, StandsWhileTheDaemonIsReadyAndEverybodyMayReadIt) {
  {
    const NoticeFile notice(cell, content);
    EXPECT_EQ(tests::read_file(path), content);
    EXPECT_NE(fs::status(path).permissions() & fs::perms::others_read, fs::perms::none);
  }
  EXPECT_EQ(files(), 0U);
}

TEST_F(NoticeFileTest, LeavesNoEmptyFileOnAFullDiskAndComesWhenThereIsRoom) {
  for (const rlim_t room_bytes : {rlim_t{0}, rlim_t{7}}) {
    std::optional<FullDisk> full(room_bytes);
    const NoticeFile notice(cell, content, 1ms);
    EXPECT_EQ(files(), 0U) << "no empty file, no part of one";
    full.reset();
    const auto until = std::chrono::steady_clock::now() + 20s;
    while (!fs::exists(path) && std::chrono::steady_clock::now() < until)
      std::this_thread::sleep_for(1ms);
    EXPECT_EQ(tests::read_file(path), content);
  }
}

TEST_F(NoticeFileTest, EndsWithTheDaemonThoughItWasNeverWritten) {
  const FullDisk full(0);
  const NoticeFile notice(cell, content, 1h);
  EXPECT_EQ(files(), 0U);
}

}  // namespace
}  // namespace driftwise
