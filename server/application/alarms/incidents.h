#pragma once
// One incident, one alarm: what follows from a condition that stands is listed under it. Pure; the
// caller states the time.
//
// A condition is a consequence of another when the other alone explains it: a run that waits for
// the device that does not answer, what that device measures and is old, further devices behind
// the same address that went with it. It is an alarm of its own when two others could explain it,
// and when it outlasts its cause by kGrace; the settle time of a hold that its cause began is not
// counted. A run waits for a device some seconds before the device
// counts as lost: what can be a consequence begins no alarm before it has stood for kTogether. What
// has become an alarm stays one while it holds: as a consequence of a later one it would be told as
// over.

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/application/ports/alarm_condition.h"
#include "server/core/cell_time.h"

namespace driftwise::application {

class Incidents {
 public:
  // Longest time between a cause and its consequences; a later condition has its own cause.
  static constexpr std::chrono::seconds kTogether{30};
  static constexpr std::chrono::seconds kGrace{30};

  // An alarm of its own stands, begun at `since`, although nothing has found its condition yet: it
  // was one before the daemon's start. At every look before group() until its source has judged.
  void stand(const std::string& kind, const std::string& subject, CellTime since, CellTime now);
  // conditions: of one look, none twice. Those that are alarms of their own, or may become one
  // (settling), the first that began first, each with its consequences as sentences, in order of
  // their beginning.
  std::vector<AlarmCondition> group(std::vector<AlarmCondition> conditions, CellTime now);

 private:
  using Key = std::pair<std::string, std::string>;  // kind, subject
  struct Known {
    CellTime since, last_seen;
    std::optional<Key> cause;
    CellTime cause_seen;
    bool own = false;  // it stays an alarm of its own: it is one, or it has outlasted its cause
  };
  std::map<Key, Known> known_;
};

}  // namespace driftwise::application
