#include "server/effects/term_evaluator.h"

#include <algorithm>
#include <cassert>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/effects/term_order.h"

namespace driftwise::effects {

Result<TermEvaluator> TermEvaluator::create(const std::vector<Term>& terms,
                                            const std::vector<std::string>& symbols) {
  TermEvaluator made;
  made.channels_ = symbols.size();
  const auto index_of = [&symbols](const std::string& symbol) -> std::ptrdiff_t {
    const auto at = std::find(symbols.begin(), symbols.end(), symbol);
    return at == symbols.end() ? -1 : at - symbols.begin();
  };
  const auto unknown = [](const Term& term, const std::string& symbol) {
    return fail(ErrorCode::invalid_argument, reasons::kUnknownChannel,
                "term " + notation(term) + " needs channel '" + symbol + "', which is not there");
  };
  for (const auto& raw : terms) {
    const Term term = canonical(raw);
    TermSlot slot;
    if (const auto ordinal = datum_of(term)) {
      slot.datum = *ordinal;
      slot.datum_channel = static_cast<int>(index_of("datum"));
      made.terms_.push_back(std::move(slot));
      continue;
    }
    for (const auto& factor : term.factors) {
      if (const auto* plain = std::get_if<Power>(&factor)) {
        const auto index = index_of(plain->symbol);
        if (index < 0) return unknown(term, plain->symbol);
        slot.factors.push_back({false, static_cast<std::size_t>(index), plain->exponent});
        continue;
      }
      DRIFTWISE_TRY(const auto call, checked(std::get<Call>(factor)));
      auto known = std::find_if(made.calls_.begin(), made.calls_.end(),
                                [&call](const CallSlot& one) { return one.call == call; });
      if (known == made.calls_.end()) {
        CallSlot added{call, {}, find_effect(call.effect)->make(call.parameters), {}};
        for (const auto& symbol : call.symbols) {
          const auto index = index_of(symbol);
          if (index < 0) return unknown(term, symbol);
          added.inputs.push_back(static_cast<std::size_t>(index));
        }
        added.scratch.resize(added.inputs.size());
        if (!find_effect(call.effect)->memoryless) made.has_memory_ = true;
        made.calls_.push_back(std::move(added));
        known = made.calls_.end() - 1;
      }
      slot.factors.push_back({true, static_cast<std::size_t>(known - made.calls_.begin()), 1});
    }
    made.terms_.push_back(std::move(slot));
  }
  made.outputs_.resize(made.calls_.size());
  return made;
}

TermEvaluator::TermEvaluator(const TermEvaluator& other)
    : channels_(other.channels_),
      has_memory_(other.has_memory_),
      terms_(other.terms_),
      outputs_(other.outputs_) {
  calls_.reserve(other.calls_.size());
  for (const auto& call : other.calls_)
    calls_.push_back({call.call, call.inputs, call.state->clone(), call.scratch});
}

TermEvaluator& TermEvaluator::operator=(const TermEvaluator& other) {
  if (this != &other) *this = TermEvaluator(other);
  return *this;
}

double TermEvaluator::column(const TermSlot& term, std::span<const double> values) const {
  if (term.datum != 0)
    return term.datum_channel >= 0 &&
                   values[static_cast<std::size_t>(term.datum_channel)] == term.datum
               ? 1.0
               : 0.0;
  double result = 1.0;
  for (const auto& factor : term.factors)
    result *=
        factor.is_call ? outputs_[factor.index] : power(values[factor.index], factor.exponent);
  return result;
}

void TermEvaluator::step(double time_s, std::span<const double> values,
                         std::span<double> columns_out) {
  for (std::size_t i = 0; i < calls_.size(); ++i) {
    auto& call = calls_[i];
    for (std::size_t k = 0; k < call.inputs.size(); ++k) call.scratch[k] = values[call.inputs[k]];
    outputs_[i] = call.state->step(time_s, call.scratch);
  }
  for (std::size_t j = 0; j < terms_.size(); ++j) columns_out[j] = column(terms_[j], values);
}

void TermEvaluator::evaluate(std::span<const double> values, std::span<double> columns_out) const {
  assert(calls_.empty());
  for (std::size_t j = 0; j < terms_.size(); ++j) columns_out[j] = column(terms_[j], values);
}

Eigen::MatrixXd TermEvaluator::block(std::span<const double> time_s,
                                     const std::vector<std::span<const double>>& values,
                                     std::size_t rows) {
  assert(values.size() == channels_ && (!has_memory() || time_s.size() == rows));
  const auto n = static_cast<Eigen::Index>(rows);
  Eigen::MatrixXd outputs(n, static_cast<Eigen::Index>(calls_.size()));
  for (std::size_t i = 0; i < calls_.size(); ++i) {
    auto& call = calls_[i];
    for (std::size_t row = 0; row < rows; ++row) {
      for (std::size_t k = 0; k < call.inputs.size(); ++k)
        call.scratch[k] = values[call.inputs[k]][row];
      outputs(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(i)) =
          call.state->step(time_s.empty() ? 0.0 : time_s[row], call.scratch);
    }
  }
  Eigen::MatrixXd result(n, static_cast<Eigen::Index>(terms_.size()));
  for (std::size_t j = 0; j < terms_.size(); ++j) {
    const auto& term = terms_[j];
    auto column_j = result.col(static_cast<Eigen::Index>(j));
    if (term.datum != 0) {
      for (std::size_t row = 0; row < rows; ++row)
        column_j[static_cast<Eigen::Index>(row)] =
            term.datum_channel >= 0 &&
                    values[static_cast<std::size_t>(term.datum_channel)][row] == term.datum
                ? 1.0
                : 0.0;
      continue;
    }
    column_j.setOnes();
    for (const auto& factor : term.factors) {
      if (factor.is_call) {
        column_j.array() *= outputs.col(static_cast<Eigen::Index>(factor.index)).array();
        continue;
      }
      const double* channel = values[factor.index].data();
      for (Eigen::Index row = 0; row < n; ++row)
        column_j[row] *= power(channel[row], factor.exponent);
    }
  }
  return result;
}

}  // namespace driftwise::effects
