#pragma once
// The last minutes of every slow channel, for joining by time and for showing the latest value.
// Bounded.

#include <cstdint>
#include <deque>
#include <limits>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "server/core/data/judged_reading.h"
#include "server/core/result.h"

namespace driftwise::application {

struct Joined {
  double value = kMissing;
  double age_s = 0;  // distance in time to the nearest reading it is made of
};

class ChannelHistory {
 public:
  static constexpr CellTime kAnyTime{std::numeric_limits<std::int64_t>::min()};

  explicit ChannelHistory(std::size_t kept_per_channel = 256) : kept_(kept_per_channel) {}

  // kMissing and rejected values are remembered as "no value", not as samples.
  void add(const Reading& reading, std::span<const RejectedValue> rejected = {});

  // The channel at an instant: linear between the sample before and the one after when both are
  // there and lie within max_age_s, else the nearest of them. A sample's instant is the middle of
  // its reading. since: only samples whose reading began at this instant or later.
  // Errors, failed_precondition: CHANNEL_MISSING ("t03_degC was never read"), CHANNEL_TOO_OLD
  // ("t03_degC too old: 22 s, limit 15 s").
  Result<Joined> at(const std::string& channel, CellTime instant, double max_age_s,
                    CellTime since = kAnyTime) const;
  // A reading of the device began at this instant or later, whatever it said.
  bool has_reading_since(const std::string& device, CellTime since) const;

  struct Latest {
    std::string channel, device;
    double value = kMissing;  // the newest that was a value
    CellTime at;
  };
  std::vector<Latest> latest() const;  // in order of first appearance
  const Latest* latest(const std::string& channel) const;

 private:
  struct Sample {
    CellTime at, began;
    double value;
  };
  struct Track {
    Latest latest;
    std::deque<Sample> samples;  // in time order
  };
  std::size_t kept_;
  std::vector<std::string> order_;
  std::unordered_map<std::string, Track> tracks_;
  std::unordered_map<std::string, CellTime> began_;  // the newest reading, by device
};

}  // namespace driftwise::application
