#pragma once
// Test of each answer of a device against the limits of its channels. Pure: state is what was
// answered before, time is that of the readings.
//
// Impossible: no value, not finite, outside the range, changed faster than physics allows. Frozen:
// more equal answers in a row than the channel's own noise makes likely. Noise goes back and forth;
// a channel that only ever went one way has shown none. Where its steps hide its noise, a room that
// turns round makes rows of any length, and other channels of its unit must have moved far
// meanwhile; of a temperature that is held, its set point. Together: all probes of a scanner step
// in the same direction between two scans, which no room does.
//
// After a step a channel stays in doubt until it steps back, whatever it drifts in between, or
// until begin_anew(): a person says so, a run begins, the instrument was zeroed.

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/core/data/judged_reading.h"
#include "server/plausibility/limits.h"

namespace driftwise::plausibility {

struct Finding {
  std::string device, channel;  // channel: of a scanner that stepped as a whole, its first probe
  std::string test;             // missing, not_finite, range, step, together, frozen
  std::string reason;
  CellTime since;  // first answer that may be false
};

class ValueJudge {
 public:
  explicit ValueJudge(const CellDescription& cell) : cell_(cell) {}  // outlives this

  // Fills reading.rejected. Devices that the cell does not know are not judged.
  std::vector<Finding> judge(JudgedReading& reading);

  // What is said next is taken as right, as far as it is possible at all: of one device, of all.
  void begin_anew(const std::string& device);
  void begin_anew();

 private:
  struct Value {
    double value = 0;
    CellTime at;
  };
  using DeviceChannel = std::pair<std::string, std::string>;
  using Others = std::map<DeviceChannel, double>;
  struct Track {
    ChannelLimit limit;
    std::optional<Value> last;  // finite and within the range
    double stepped_by = 0;      // sum of the steps since the channel was last right
    // Equal answers in a row, and what is known of them from before.
    std::optional<Value> equal;
    int equal_count = 0, longest_equal = 0;
    int direction = 0;         // of the last change: +1, -1; 0 before the first
    int reversals = 0;         // changes against the one before
    int changes = 0;           // at the ends of rows, without those of a ramp
    std::int64_t answers = 0;  // of the rows that are over, without those of a ramp
    bool is_frozen = false;    // the row of now
    double finest_step = std::numeric_limits<double>::max();  // the smallest change seen
    int single_steps = 0;  // changes by one such step, as far as was known then
    Others others_then;    // of a coarse channel: its unit's at the row's begin
    int moved_count = 0;   // answers of the row since they moved
  };
  struct Whole {  // a scanner
    double stepped_by_k = 0;
  };
  struct Change;
  Track& track_of(const DeviceDescription& device, const std::string& channel);
  std::optional<Finding> judge_value(const std::string& device, const ChannelValue& value,
                                     Track& track, CellTime at) const;
  std::optional<Finding> judge_step(Track& track, const ChannelValue& value, CellTime at) const;
  std::optional<Finding> judge_equal(const std::string& device, const ChannelValue& value,
                                     Track& track, CellTime at) const;
  bool is_coarse(const Track& track) const;
  void end_row(Track& track, double change) const;
  Others others_of(const DeviceChannel& channel, const ChannelLimit& limit) const;
  bool others_have_moved(const Track& track) const;
  std::optional<Finding> judge_together(const DeviceDescription& device, const Reading& reading);

  const CellDescription& cell_;
  std::map<DeviceChannel, Track> tracks_;
  std::map<std::string, Whole> scanners_;
};

// Answers of a channel before the present row of equal ones.
struct EqualAnswers {
  int longest = 0, reversals = 0, changes = 0;
  std::int64_t answers = 0;
};
// Equal answers in a row that make a channel frozen: more than three times the longest row seen,
// more than its own rate of repetition makes with a chance of kByChance, and at least kFewestEqual;
// 0 (not known) before kReversalsToKnow reversals, which are two thirds of the changes of white
// noise. The longest row alone says too little at first: of 20 rows of a channel that repeats
// itself three times in four the longest has some 12 answers, of 5000 rows 30.
int frozen_limit(const ChannelLimit& limit, const EqualAnswers& before);
inline constexpr int kFewestEqual = 8, kReversalsToKnow = 20;
inline constexpr double kByChance = 1e-9;
// A channel whose steps hide its noise answers so many times for each change, or more than
// kRepeats times with so large a share of its changes by a single step: rows are long where its
// drift is in the middle of a step, however short they were at its edge. It is frozen when another
// one of its unit has moved by so many of its steps while it stood.
inline constexpr int kCoarseAnswers = 5, kStepsOfOthers = 5;
inline constexpr double kRepeats = 1.5, kSingleSteps = 0.8;

}  // namespace driftwise::plausibility
