#pragma once
// One condition of the cell that asks for a person, as an object: acknowledged by itself.

#include <string>
#include <vector>

#include "server/core/records/watch_records.h"

namespace driftwise::application {

struct AlarmCondition {
  AlarmLevel level = AlarmLevel::warning;
  std::string kind, subject, message;
  // Links to a condition that may explain this one: the device behind it (channel.stale), the
  // device's address (device.lost), the run's own reason (run.waiting).
  std::string device = {}, address = {}, detail = {};
  std::vector<std::string> consequences = {};  // sentences: incidents.h
  // It may turn out to follow from another one, or to be over in a moment: begins no alarm yet, and
  // ends none. It explains others all the same.
  bool settling = false;
  // A condition whose cause is back and is only confirmed for a stated time: while that lasts, it
  // does not outlast its cause.
  bool is_ending = false;
};

}  // namespace driftwise::application
