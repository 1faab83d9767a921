#pragma once
// Limits of a user's own: [[channel_alarm]] of the cell file. Pure; the caller states the time.

#include <optional>
#include <string>
#include <vector>

#include "server/application/ports/alarm_condition.h"
#include "server/core/cell_time.h"
#include "server/core/description/notify_description.h"

namespace driftwise::application {

class ChannelAlarms {
 public:
  explicit ChannelAlarms(std::vector<ChannelAlarmDescription> limits);

  // The newest value of one channel; kMissing says nothing. device: where it comes from.
  void take(const std::string& channel, const std::string& device, double value, CellTime now);
  // An alarm of one of these limits stood before the start: it ends by its hysteresis, and needs no
  // for_s again.
  void stand(const std::string& kind, const std::string& subject);
  // Whether a value was seen since the start. True where no limit has this alarm: it is no more.
  bool has_judged(const std::string& kind, const std::string& subject) const;
  // Those beyond their limit for at least for_s, or not yet back by the hysteresis.
  std::vector<AlarmCondition> conditions(CellTime now) const;

 private:
  struct Limit {
    ChannelAlarmDescription rule;
    std::string device;
    double value = 0;
    std::optional<CellTime> beyond_since;
    bool stands = false;
    bool is_read = false;  // a value was seen
  };
  std::vector<Limit> limits_;
};

}  // namespace driftwise::application
