#pragma once
// Who may move the robot: one client at a time, for a limited time, by a token that only it knows.
// Pure but for the random token; the caller states the time.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "server/application/ports/caller.h"
#include "server/core/cell_time.h"
#include "server/core/result.h"
#include "server/core/utc_map.h"

namespace driftwise::application {

struct Lease {
  std::string token, holder, peer;
  CellTime until;
};

class LeaseBook {
 public:
  // utc: for messages; empty: cell time is UTC.
  explicit LeaseBook(std::function<UtcTime(CellTime)> utc = {});
  ~LeaseBook();

  // Without a token: a new lease, when nobody holds one or the last has run out. With the holder's
  // token: renewed. duration: 1 s to 1 h of cell time. Errors: permission_denied LEASE_HELD (who,
  // until when, what to do), LEASE_UNKNOWN (a token that is not the present one);
  //   aborted STOPPED_MEANWHILE (a token that a stop ended); invalid_argument LEASE_DURATION.
  Result<Lease> take(const Caller& caller, Nanoseconds duration, const std::string& token,
                     CellTime now);
  // Errors: permission_denied LEASE_UNKNOWN.
  Result<void> give_up(const std::string& token, CellTime now);
  // A person's stop: the lease ends, and its token moves nothing any more. why: a sentence.
  void end(std::string why);
  // Errors: permission_denied LEASE_REQUIRED (no token), LEASE_HELD, LEASE_EXPIRED, LEASE_UNKNOWN;
  // aborted STOPPED_MEANWHILE.
  Result<void> check(const std::string& token, CellTime now) const;

  std::optional<Lease> present(CellTime now) const;  // its token blanked; none when it has run out

 private:
  std::string text_of(CellTime instant) const;
  struct Entry;
  std::unique_ptr<Entry> entry_;
  std::string ended_token_, ended_why_;  // by the last stop that ended a lease
  std::function<UtcTime(CellTime)> utc_;
};

}  // namespace driftwise::application
