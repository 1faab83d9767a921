#pragma once
// Ctrl-C, or a terminal that goes away: the call under way is cancelled and the command ends with
// 130. Made once, in main, before any other thread.

#include <atomic>
#include <functional>
#include <mutex>
#include <set>
#include <thread>

namespace driftwise::cli {

class Interrupt {
 public:
  // Blocks SIGINT, SIGTERM and SIGHUP in this and all later threads and waits for them on a thread
  // of its own. One that the parent ignores (nohup, a job in the background) stays ignored.
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  bool raised() const { return raised_; }
  // From now on somebody looks at raised() and puts things in order. Before that, a command of
  // files alone has nothing to put in order: the first signal ends the process with 130.
  void attend() { attended_ = true; }

  // While it lives, cancel is called (once, on the other thread) when the interrupt comes; at once
  // if it has come. Scopes of several threads live side by side and end in any order.
  class Scope {
   public:
    Scope(Interrupt* interrupt, std::function<void()> cancel);
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    friend class Interrupt;
    Interrupt* interrupt_;  // may be null: nothing to listen to
    std::function<void()> cancel_;
  };

 private:
  void wait();
  std::atomic<bool> raised_{false}, over_{false}, attended_{false};
  std::mutex mutex_;
  std::set<Scope*> live_;
  std::thread thread_;
};

}  // namespace driftwise::cli
