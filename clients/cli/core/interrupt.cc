#include "clients/cli/core/interrupt.h"

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <utility>

namespace driftwise::cli {
namespace {

bool is_ignored(int signal) {
  struct sigaction action {};
  return sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

sigset_t signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGUSR1);  // our own wake-up at the end
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
    if (!is_ignored(signal)) sigaddset(&set, signal);
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
    const std::lock_guard lock(mutex_);
    if (raised_) _exit(130);  // a second Ctrl-C: whatever holds us up, leave
    raised_ = true;
    if (live_.empty() && !attended_) _exit(130);
    for (const Scope* scope : live_) scope->cancel_();
  }
}

Interrupt::Scope::Scope(Interrupt* interrupt, std::function<void()> cancel)
    : interrupt_(interrupt), cancel_(std::move(cancel)) {
  if (interrupt_ == nullptr) return;
  const std::lock_guard lock(interrupt_->mutex_);
  if (interrupt_->raised_) cancel_();
  interrupt_->live_.insert(this);
}

Interrupt::Scope::~Scope() {
  if (interrupt_ == nullptr) return;
  const std::lock_guard lock(interrupt_->mutex_);
  interrupt_->live_.erase(this);
}

}  // namespace driftwise::cli
