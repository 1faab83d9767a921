#pragma once
// Who wants to hear of something. A callback runs on the executor's thread and must return at once:
// whoever has a slow client queues on his own side, so that a slow watcher never slows a run.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <utility>

namespace driftwise::application {

template <class... Values>
class WatchList {
 public:
  using Callback = std::function<void(const Values&...)>;

  // Heard until the handle is gone. The handle may outlive the list.
  std::shared_ptr<void> add(Callback callback) {
    const auto key = ++callbacks_->last;
    callbacks_->entries.emplace(key, std::move(callback));
    return std::shared_ptr<void>(static_cast<void*>(callbacks_.get()),
                                 [weak = std::weak_ptr(callbacks_), key](void*) {
                                   if (const auto alive = weak.lock()) alive->entries.erase(key);
                                 });
  }

  void publish(const Values&... values) const {
    const auto callbacks =
        callbacks_;  // a callback may end its own watch, or the owner of this list
    for (auto next = callbacks->entries.begin(); next != callbacks->entries.end();) {
      const auto key = next->first;
      const Callback callback = next->second;
      callback(values...);
      next = callbacks->entries.upper_bound(key);
    }
  }
  bool empty() const { return callbacks_->entries.empty(); }

 private:
  struct Callbacks {
    std::uint64_t last = 0;
    std::map<std::uint64_t, Callback> entries;
  };
  std::shared_ptr<Callbacks> callbacks_ = std::make_shared<Callbacks>();
};

}  // namespace driftwise::application
