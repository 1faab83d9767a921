#pragma once
// What is told of alarms outside the machine, and to whom.

#include <cstdint>
#include <string>
#include <vector>

#include "server/core/records/audit_records.h"
#include "server/core/records/watch_records.h"
#include "server/core/utc_map.h"

namespace driftwise {

enum class NewsKind : std::uint8_t { firing, repeat, resolved };

struct AlarmNews {
  AlarmRecord alarm;
  NewsKind kind = NewsKind::firing;
  UtcTime since, cleared;  // of the alarm; cleared 0: it holds
};

// One message. It never holds more than kMost alarms.
struct Notice {
  static constexpr std::size_t kMost = 50;
  std::string cell, web_address;  // address of the page; empty: none
  UtcTime at;
  std::vector<AlarmNews> news;
  bool test = false;  // without news: somebody wants to know whether it arrives
  // The numbers of its alarms are those of a cell's record. A watchdog counts by itself, and its
  // numbers are another alarm's in the cell.
  bool is_of_record = true;
  std::string remedy = {};  // what the person who reads it can do, one line; empty: nothing to say
};

// The sign of life that a watchdog expects.
struct LifeSign {
  std::string cell, version;
  UtcTime at;
  std::string run_state;    // "idle", "running"
  std::int64_t run = 0;     // 0: none under way
  std::int64_t alarms = 0;  // that stand and nobody has acknowledged
  ChainHead head;           // of the record's chain
  double every_s = 0;       // wall time until the next one
};

// What one receiver knows of one alarm; utc_ns 0: not told.
struct TellingRecord {
  AlarmId alarm;
  std::string receiver;
  CellTime firing, last, resolved;
  std::int64_t count = 0;   // messages that arrived
  std::int64_t failed = 0;  // tries since the last one that arrived
  CellTime tried;
  std::string error;  // of the last try; empty: it arrived
};

// What is to be told when the daemon starts.
struct OpenTellings {
  struct Receiver {
    std::string name;
    CellTime known_since;  // what was over before is not told
  };
  std::vector<Receiver> receivers;
  std::vector<AlarmRecord> alarms;      // that hold, or were over not long ago
  std::vector<TellingRecord> tellings;  // of these alarms
};

}  // namespace driftwise
