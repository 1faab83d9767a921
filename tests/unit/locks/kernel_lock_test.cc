// One holder at a time, by name; the kernel releases what a killed process held.

#include "server/locks/kernel_lock.h"

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/locks/claims.h"

namespace driftwise::locks {
namespace {

using testing::HasSubstr;

std::string own_name(const char* what) { return std::string(what) + std::to_string(getpid()); }

TEST(KernelLock, IsHeldOnceAndNamesItsHolder) {
  auto first = KernelLock::take(own_name("test/once-"));
  ASSERT_TRUE(first) << first.error().message;
  const auto second = KernelLock::take(own_name("test/once-"));
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().reason, "LOCK_HELD");
  EXPECT_EQ(second.error().message, "process " + std::to_string(getpid()));
  EXPECT_TRUE(KernelLock::take(own_name("test/another-")));
  *first = KernelLock();
  EXPECT_TRUE(KernelLock::take(own_name("test/once-")));
}

TEST(KernelLock, IsReleasedByTheKernelAtAKill) {
  int told[2];
  ASSERT_EQ(pipe(told), 0);
  const std::string name = own_name("test/kill-");
  const pid_t child = fork();
  if (child == 0) {
    const auto lock = KernelLock::take(name);
    const char answer = lock ? 'y' : 'n';
    (void)!write(told[1], &answer, 1);
    pause();
    _exit(0);
  }
  char answer = 0;
  ASSERT_EQ(read(told[0], &answer, 1), 1);
  EXPECT_EQ(answer, 'y');
  const auto refused = KernelLock::take(name);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "process " + std::to_string(child));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_TRUE(KernelLock::take(name));
  close(told[0]);
  close(told[1]);
}

TEST(Claims, AreHeldOnceByAProcessAndRefusedToTheNext) {
  Claims ours, theirs;
  const std::string key = own_name("tcp:192.0.2.7:");
  ASSERT_TRUE(ours.take("axis", key));
  EXPECT_TRUE(ours.take("axis", key)) << "held already";
  const auto refused = theirs.take("stage", key);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "CONTROLLER_IN_USE");
  EXPECT_THAT(refused.error().message, HasSubstr("device 'stage'"));
  EXPECT_THAT(refused.error().message, HasSubstr(std::to_string(getpid())));
}

}  // namespace
}  // namespace driftwise::locks
