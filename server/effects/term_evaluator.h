#pragma once
// The one fold from channel values to columns: the design matrix of a fit, the forward simulation
// and the live compensation all call it, so offline and online agree to the last digit.
//
// A copy copies the memory of every effect: fork it to look ahead, keep one per stream.
// Thread: one at a time; no allocation in step() after create().

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "server/core/channel.h"
#include "server/core/result.h"
#include "server/effects/effect.h"
#include "server/effects/term.h"

namespace driftwise::effects {

class TermEvaluator {
 public:
  // terms: any order, the constant allowed; symbols: the channel table, values come in this order.
  // datum(k) terms read the symbol "datum" (an ordinal) when the table has it, else they are 0.
  // Errors: invalid_argument UNKNOWN_CHANNEL (names term and channel), UNKNOWN_EFFECT, BAD_EFFECT.
  static Result<TermEvaluator> create(const std::vector<Term>& terms,
                                      const std::vector<std::string>& symbols);

  TermEvaluator(const TermEvaluator& other);
  TermEvaluator& operator=(const TermEvaluator& other);
  TermEvaluator(TermEvaluator&&) noexcept = default;
  TermEvaluator& operator=(TermEvaluator&&) noexcept = default;
  ~TermEvaluator() = default;

  std::size_t columns() const { return terms_.size(); }
  std::size_t channels() const { return channels_; }
  bool has_memory() const { return has_memory_; }

  // One reading. values: channels() numbers, NaN where missing; columns_out: columns() numbers, NaN
  // where a value it needs is missing. Rows come in time order; time_s is ignored by terms without
  // memory.
  void step(double time_s, std::span<const double> values, std::span<double> columns_out);

  // The columns that step() would give, without advancing: for terms that call no effect
  // (asserted).
  void evaluate(std::span<const double> values, std::span<double> columns_out) const;

  // Many readings: the same numbers as step() row by row, columns without memory in whole columns.
  // values[c]: rows numbers of channel c; time_s: rows numbers, or empty when has_memory() is
  // false.
  Eigen::MatrixXd block(std::span<const double> time_s,
                        const std::vector<std::span<const double>>& values, std::size_t rows);

 private:
  struct FactorSlot {
    bool is_call = false;
    std::size_t index = 0;  // of a channel or of a call
    int exponent = 1;
  };
  struct TermSlot {
    std::vector<FactorSlot> factors;
    int datum = 0;  // k of datum(k)
    int datum_channel = -1;
  };
  struct CallSlot {
    Call call;
    std::vector<std::size_t> inputs;
    std::unique_ptr<EffectState> state;
    std::vector<double> scratch;
  };

  TermEvaluator() = default;
  double column(const TermSlot& term, std::span<const double> values) const;

  std::size_t channels_ = 0;
  bool has_memory_ = false;
  std::vector<TermSlot> terms_;
  std::vector<CallSlot> calls_;  // each distinct call once
  std::vector<double> outputs_;  // of the calls, at the present reading
};

// x * x * ... * x, left to right: the one definition of a power, whoever evaluates it.
inline double power(double value, int exponent) {
  double result = value;
  for (int i = 1; i < exponent; ++i) result *= value;
  return result;
}

}  // namespace driftwise::effects
