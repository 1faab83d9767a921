#pragma once
// The slow side of a model: the last good value of every channel it reads that no request states,
// and the effects with memory that observe them. Advanced by observed readings only.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "server/core/cell_time.h"
#include "server/core/channel.h"
#include "server/core/data/reading.h"
#include "server/core/result.h"
#include "server/core/unit_conversion.h"
#include "server/effects/term_evaluator.h"

namespace driftwise::compensation {

// The slow part of one term: a product of channels' powers and effects' outputs; empty: 1.
struct SlowProduct {
  struct Factor {
    std::size_t index = 0;
    int exponent = 1;
  };
  std::vector<Factor> powers;      // index: of a channel
  std::vector<std::size_t> calls;  // index: of an effect
};

using CallSlopes = std::vector<std::vector<double>>;

class SlowState {
 public:
  struct Latest {
    double value = kMissing;
    CellTime at;
  };

  // The channel's index, added when it is new.
  std::size_t add_channel(const Channel& channel);
  // The effect's index, added when it is new; its symbols must be channels. Errors: those of
  // TermEvaluator::create.
  Result<std::size_t> add_call(const effects::Call& call);

  // Name under which the cell reads a channel, and from the cell's unit to the model's: a model
  // fitted in K is served from a thermometer in degC. At first the channel's own name.
  struct ReadAs {
    std::string name;
    UnitConversion to_unit;
  };
  void set_read_as(std::size_t channel, ReadAs by) { read_as_[channel] = std::move(by); }
  const std::vector<ReadAs>& read_as() const { return read_as_; }

  // Readings by the names of read_as(). Unknown names and kMissing values change nothing.
  void observe(std::span<const ChannelValue> values, CellTime at);
  // The same by channel, in the order and the units of channels(); kMissing: nothing new.
  void take(std::span<const double> by_channel, CellTime at);

  const std::vector<Channel>& channels() const { return channels_; }
  const std::vector<Latest>& latest() const { return latest_; }
  std::optional<std::size_t> find(const std::string& symbol) const;
  // u: standard uncertainty of what the channel was before its first reading; 0: it was the same.
  void set_before_first(std::size_t channel, double u) { before_first_[channel] = u; }
  // Each effect's present output. One that saw nothing yet: in equilibrium with these channel
  // values (one per channel), NaN when none are given.
  std::vector<double> call_values(std::span<const double> channels_instead = {}) const;
  // Each effect's output in equilibrium with these channel values, whatever it saw.
  std::vector<double> settled_calls(std::span<const double> channels) const;
  // Part of each effect's present output that the time before its first reading has, as a standard
  // uncertainty with its sign: the output of a twin whose channels were higher before then by
  // set_before_first(), minus the output. 0 for an effect that saw nothing.
  std::vector<double> call_shifts() const;
  // Of all effects, the longest time constant in seconds; 0: none has one.
  double longest_tau_s() const;
  // By how much each effect's output grows per unit of each channel, once it has settled: calls x
  // channels. A constant error of a sensor arrives so.
  CallSlopes settled_slopes(std::span<const double> channels) const;
  const std::vector<std::size_t>& channels_of_call(std::size_t call) const {
    return calls_[call].channels;
  }

 private:
  struct Tracker {
    effects::Call call;
    effects::TermEvaluator
        evaluator;  // of this one effect, stepped when one of its channels has news
    std::vector<std::size_t> channels;
    double output = kMissing;
    // The same effect with another past; none until the first reading, and when no spread is known.
    std::optional<effects::TermEvaluator> twin{};
    double twin_output = kMissing;
  };
  void begin_twin(Tracker& tracker, double time_s, std::span<const double> inputs) const;
  static double settled(const Tracker& tracker, std::span<const double> channels);
  std::vector<Channel> channels_;
  std::vector<ReadAs> read_as_;
  std::vector<Latest> latest_;
  std::vector<double> before_first_;  // per channel; 0: not set
  std::vector<Tracker> calls_;
  std::optional<CellTime>
      origin_;  // effects count seconds from here: small numbers keep their digits
};

double value_of(const SlowProduct& product, std::span<const double> channels,
                std::span<const double> calls);
// By the output of one effect.
double derivative_by_call(const SlowProduct& product, std::size_t call,
                          std::span<const double> channels, std::span<const double> calls);
// By one channel. Effects with memory count with the slope that they settle at: 1 of a lag, 0 of a
// rate.
double derivative_of(const SlowProduct& product, std::size_t channel,
                     std::span<const double> channels, std::span<const double> calls,
                     const CallSlopes& slopes);

}  // namespace driftwise::compensation
