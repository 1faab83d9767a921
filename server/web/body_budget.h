#pragma once
// Memory for the bodies of requests, from their first byte until their answer is out. A body that
// got no byte for a second gives way to one that grows. Web thread.

#include <chrono>
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <string>

#include "server/web/door_quotas.h"

namespace driftwise::web {

class BodyBudget {
 public:
  struct Limits {
    std::size_t in_all = std::size_t{112} << 20;   // three of the largest requests
    std::size_t per_peer = std::size_t{96} << 20;  // programs of one computer are one peer
    std::chrono::milliseconds stalled{1000};
  };
  // Bytes up to here cost nothing: a call of a person is never refused for another one's file.
  static constexpr std::size_t kFree = 64 * 1024;

  explicit BodyBudget(Limits limits) : limits_(limits) {}
  BodyBudget() : BodyBudget(Limits{}) {}

  // One request's body. Its bytes are given back when it goes.
  class Share {
   public:
    Share(BodyBudget& budget, std::string peer, std::function<void()> close);
    ~Share();
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;

    // The body has this many bytes now. False: there is no room, and nobody who would make it.
    bool grow_to(std::size_t bytes, DoorInstant now);
    void complete() { complete_ = true; }  // at work from now on: it is not closed for another one

   private:
    friend class BodyBudget;
    BodyBudget& budget_;
    std::string peer_;
    std::function<void()> close_;
    std::size_t bytes_ = 0;
    DoorInstant last_byte_{};
    bool complete_ = false;
    std::list<Share*>::iterator place_;
  };

  std::size_t bytes() const { return bytes_; }

 private:
  bool fits(const Share& asking, std::size_t more) const;
  bool close_slowest(const Share& asking, DoorInstant now);

  Limits limits_;
  std::list<Share*> shares_;
  std::size_t bytes_ = 0;
};

}  // namespace driftwise::web
