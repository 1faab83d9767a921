#pragma once
// Recipients of one receiver's mails whom the server refuses while it takes the mail for others.
// One who is refused for now (4xx, greylisting) gets the same mail again after 1, 2, 4 s and so on;
// one who is refused for good (5xx) does not. Each is forgotten with the first mail that is taken
// for them. In memory: a restart forgets the mails that wait. Pure; the caller states the time.

#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/ports/outside/notifier.h"

namespace driftwise::application {

class RefusedRecipients {
 public:
  static constexpr std::size_t kMostWaiting = 20;  // mails of one recipient; the oldest goes
  static constexpr double kFirstRetry_s = 1, kLongestRetry_s = 300;

  // A mail went to all of `to`, and was taken for all but these.
  void take(const Notice& notice, const std::vector<std::string>& to,
            const std::vector<Delivery::Refused>& refused, CellTime now);

  struct Due {
    std::string address;
    Notice notice;
  };
  std::optional<Due> due(CellTime now) const;
  // What became of it. least_wait_s: until the next try.
  void tried_again(const std::string& address, const Result<Delivery>& said, CellTime now,
                   double least_wait_s);

  struct Failing {
    std::string address, why;
    CellTime since;
    bool for_now = false;
  };
  // Those refused for good, and those refused for now for at least patience_s.
  std::vector<Failing> failing(CellTime now, double patience_s) const;
  // A mail was taken for this address since the start.
  bool has_reached(const std::string& address) const { return reached_.contains(address); }

 private:
  struct Recipient {
    std::string why;
    bool for_now = false;
    CellTime since, next_try;
    double retry_s = kFirstRetry_s;
    std::deque<Notice> waiting;  // oldest first
  };
  std::map<std::string, Recipient> refused_;  // by address
  std::set<std::string> reached_;
};

}  // namespace driftwise::application
