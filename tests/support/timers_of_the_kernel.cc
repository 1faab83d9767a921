// Preloaded before libfaketime: timers reach the kernel as the program set them. libfaketime adds
// the faked offset of the wall clock to a timer of CLOCK_MONOTONIC too when its instant is
// absolute. Asio sets "1 ns after the start of the machine" for "at once": with a clock that is set
// back by a day, on a machine that runs for less than a day, no timer of the program ends any more.

#include <sys/syscall.h>
#include <sys/timerfd.h>
#include <unistd.h>

extern "C" int timerfd_settime(int timer, int flags, const itimerspec* wanted,
                               itimerspec* before) noexcept {
  return static_cast<int>(::syscall(SYS_timerfd_settime, timer, flags, wanted, before));
}
