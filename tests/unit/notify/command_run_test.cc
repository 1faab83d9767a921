// A command as a receiver: arguments without a shell, an end with all that it started.

#include "server/notify/command_run.h"

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <ctime>
#include <filesystem>
#include <thread>

#include "tests/support/process.h"

namespace driftwise::notify {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;
const std::atomic<bool> kGoOn{false};

double thread_cpu_s() {
  timespec used{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

TEST(CommandRun, GivesTheInputAndReturnsTheLastLine) {
  const auto said = run_command({"cat"}, "one\ntwo\n", milliseconds(20'000), kGoOn);
  ASSERT_TRUE(said) << said.error().message;
  EXPECT_EQ(*said, "two");
}

TEST(CommandRun, PassesTextThatAShellWouldObeyAsItIs) {
  const auto said =
      run_command({"printf", "%s", "$(id) `id`; id"}, "", milliseconds(20'000), kGoOn);
  ASSERT_TRUE(said) << said.error().message;
  EXPECT_EQ(*said, "$(id) `id`; id");
}

TEST(CommandRun, InheritsNoSocketOfTheDaemon) {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);  // without CLOEXEC, as Asio opens them
  ASSERT_GE(socket, 0);
  const auto said = run_command({"sh", "-c", "echo $(ls -l /proc/self/fd | grep -c socket)"}, "",
                                milliseconds(20'000), kGoOn);
  ::close(socket);
  ASSERT_TRUE(said) << said.error().message;
  EXPECT_EQ(*said, "0");
}

TEST(CommandRun, AMegabyteOfInputAndOutputPasses) {
  ::signal(SIGPIPE, SIG_IGN);  // as the programs do
  const std::string much(1 << 20, 'x');
  EXPECT_TRUE(run_command({"cat"}, much, milliseconds(20'000), kGoOn));
  EXPECT_TRUE(run_command({"true"}, much, milliseconds(20'000), kGoOn));  // it reads nothing
}

TEST(CommandRun, SaysWithWhichCodeItEnded) {
  const auto said =
      run_command({"sh", "-c", "echo no such host >&2; exit 3"}, "", milliseconds(20'000), kGoOn);
  ASSERT_FALSE(said);
  EXPECT_EQ(said.error().reason, "NOT_DELIVERED");
  EXPECT_THAT(said.error().message, HasSubstr("exit code 3: no such host"));
  EXPECT_FALSE(run_command({"/no/such/program"}, "", milliseconds(20'000), kGoOn));
  EXPECT_FALSE(run_command({}, "", milliseconds(20'000), kGoOn));
}

// Fifty looks in this second, a few microseconds each: a tenth of it leaves room for a sanitizer.
TEST(CommandRun, ACommandWhoseOutputGoesElsewhereCostsNoProcessorTime) {
  const double before_s = thread_cpu_s();
  const auto said =
      run_command({"sh", "-c", "exec >/dev/null 2>&1; sleep 1"}, "", milliseconds(20'000), kGoOn);
  const double used_s = thread_cpu_s() - before_s;
  ASSERT_TRUE(said) << said.error().message;
  EXPECT_EQ(*said, "exit code 0");
  EXPECT_LT(used_s, 0.1);
}

TEST(CommandRun, EndsWithAllThatItStartedAtTheLimit) {
  tests::TemporaryFolder folder;
  const std::string file = folder.path() + "/pid";
  const auto said = run_command({"sh", "-c", "sleep 1000 & echo $! > " + file + "; wait"}, "",
                                milliseconds(1500), kGoOn);
  ASSERT_FALSE(said);
  EXPECT_THAT(said.error().message, HasSubstr("longer than"));
  const pid_t started = std::stoi(tests::read_file(file));
  const auto is_gone = [&] {  // a zombie of a parent that does not reap counts as gone
    std::error_code none;
    if (!std::filesystem::exists("/proc/" + std::to_string(started), none)) return true;
    return tests::read_file("/proc/" + std::to_string(started) + "/stat").find(") Z") !=
           std::string::npos;
  };
  for (int i = 0; i < 1000 && !is_gone(); ++i) std::this_thread::sleep_for(milliseconds(5));
  EXPECT_TRUE(is_gone());
}

TEST(CommandRun, EndsWhenTheProgramEnds) {
  const std::atomic<bool> stop{true};
  const auto said = run_command({"sleep", "1000"}, "", milliseconds(20'000), stop);
  ASSERT_FALSE(said);
  EXPECT_EQ(said.error().reason, "SHUTTING_DOWN");
}

}  // namespace
}  // namespace driftwise::notify
