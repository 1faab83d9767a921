#include "clients/cli/core/interrupt.h"

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <utility>

namespace driftwise::cli {
namespace {

sigset_t signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1})
    sigaddset(&set, signal);  // USR1: our own wake-up at the end
  return set;
}

}  // namespace

Interrupt::Interrupt() {
  const sigset_t set = signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  thread_ = std::thread([this] { wait(); });
}

Interrupt::~Interrupt() {
  over_ = true;
  pthread_kill(thread_.native_handle(), SIGUSR1);
  thread_.join();
}

void Interrupt::wait() {
  const sigset_t set = signals();
  while (!over_) {
    int signal = 0;
    if (sigwait(&set, &signal) != 0 || signal == SIGUSR1) continue;
    if (raised_.exchange(true)) _exit(130);  // a second Ctrl-C: whatever holds us up, leave
    const std::lock_guard lock(mutex_);
    if (!cancel_ && !attended_) _exit(130);
    if (cancel_) cancel_();
  }
}

Interrupt::Scope::Scope(Interrupt* interrupt, std::function<void()> cancel)
    : interrupt_(interrupt) {
  if (interrupt_ == nullptr) return;
  const std::lock_guard lock(interrupt_->mutex_);
  if (interrupt_->raised_) cancel();
  outer_ = std::exchange(interrupt_->cancel_, std::move(cancel));
}

Interrupt::Scope::~Scope() {
  if (interrupt_ == nullptr) return;
  const std::lock_guard lock(interrupt_->mutex_);
  interrupt_->cancel_ = std::move(outer_);
}

}  // namespace driftwise::cli
