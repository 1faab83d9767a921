// Ctrl-C while calls of several threads are under way. Each case is a process of its own: the
// signals go to whoever does not block them.

#include "clients/cli/core/interrupt.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <future>
#include <optional>
#include <thread>

namespace driftwise::cli {
namespace {

using std::chrono::seconds;

class InterruptTest : public testing::Test {
 protected:
  void SetUp() override { testing::FLAGS_gtest_death_test_style = "threadsafe"; }
};

// 0: cancelled within the limit.
int exit_of(std::future<void> cancelled) {
  return cancelled.wait_for(seconds(20)) == std::future_status::ready ? 0 : 1;
}

// Main's call begins while the lease is renewed, and goes on when that has ended.
[[noreturn]] void interrupt_after_a_renewal() {
  Interrupt interrupt;
  interrupt.attend();
  std::promise<void> renewing, is_mains_under_way, cancelled;
  std::thread renewal([&] {
    const Interrupt::Scope call(&interrupt, [] { _exit(2); });
    renewing.set_value();
    is_mains_under_way.get_future().wait();
  });
  renewing.get_future().wait();
  const Interrupt::Scope call(&interrupt, [&] { cancelled.set_value(); });
  is_mains_under_way.set_value();
  renewal.join();
  kill(getpid(), SIGINT);
  _exit(exit_of(cancelled.get_future()));
}

// The renewal begins within main's call, and outlives it.
[[noreturn]] void interrupt_within_a_renewal() {
  Interrupt interrupt;
  interrupt.attend();
  std::promise<void> cancelled;
  std::optional<Interrupt::Scope> mains, renewals;
  mains.emplace(&interrupt, [] { _exit(2); });  // its context is gone when the signal comes
  std::thread([&] { renewals.emplace(&interrupt, [&] { cancelled.set_value(); }); }).join();
  mains.reset();
  kill(getpid(), SIGINT);
  const int exit = exit_of(cancelled.get_future());
  renewals.reset();
  _exit(exit);
}

[[noreturn]] void interrupt_both_calls() {
  Interrupt interrupt;
  interrupt.attend();
  std::promise<void> one, other;
  const Interrupt::Scope mains(&interrupt, [&] { one.set_value(); });
  const Interrupt::Scope renewals(&interrupt, [&] { other.set_value(); });
  kill(getpid(), SIGTERM);
  _exit(exit_of(one.get_future()) + exit_of(other.get_future()));
}

// A first signal that counted would make the second one end the process with 130.
[[noreturn]] void hang_up_under_nohup() {
  signal(SIGHUP, SIG_IGN);
  Interrupt interrupt;
  interrupt.attend();
  std::promise<void> cancelled;
  const Interrupt::Scope call(&interrupt, [&] { cancelled.set_value(); });
  kill(getpid(), SIGHUP);
  if (interrupt.raised()) _exit(2);
  kill(getpid(), SIGTERM);
  _exit(exit_of(cancelled.get_future()));
}

TEST_F(InterruptTest, CancelsACallThatBeganWhileAnotherThreadsWasUnderWay) {
  EXPECT_EXIT(interrupt_after_a_renewal(), testing::ExitedWithCode(0), "");
}

TEST_F(InterruptTest, CancelsNoCallThatHasEnded) {
  EXPECT_EXIT(interrupt_within_a_renewal(), testing::ExitedWithCode(0), "");
}

TEST_F(InterruptTest, CancelsEveryCallThatIsUnderWay) {
  EXPECT_EXIT(interrupt_both_calls(), testing::ExitedWithCode(0), "");
}

TEST_F(InterruptTest, LeavesASignalAloneThatTheParentIgnores) {
  EXPECT_EXIT(hang_up_under_nohup(), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace driftwise::cli
