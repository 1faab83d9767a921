#include "server/calibration/design/predict.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "server/calibration/design/design.h"
#include "server/core/data/overruns.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/effects/direct_symbols.h"
#include "server/effects/term_evaluator.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

constexpr std::size_t kPredictRows = 4096;

std::size_t chunks_in(const Dataset& dataset) {
  return (dataset.rows + kPredictRows - 1) / kPredictRows;
}

// Feeds the rows through the evaluator in chunks; use(first row, columns): in order, or where no
// term has memory on the executor's threads.
Result<void> for_each_chunk(const Dataset& dataset, const std::vector<effects::Term>& terms,
                            const Executor& executor,
                            const std::function<void(Eigen::Index, const Eigen::MatrixXd&)>& use) {
  std::vector<std::string> symbols;
  for (const auto& term : terms)
    for (const auto& symbol : effects::symbols_of(term))
      if (std::ranges::find(symbols, symbol) == symbols.end()) symbols.push_back(symbol);
  std::vector<std::span<const double>> values;
  for (const auto& symbol : symbols) {
    const auto column = dataset.values_of(symbol);
    if (column.empty())
      return fail(ErrorCode::invalid_argument, reasons::kUnknownChannel,
                  "the model needs channel '" + symbol + "', which the data lack");
    values.emplace_back(column);
  }
  const std::vector<double> datums = datum_ordinals(dataset);
  symbols.push_back("datum");
  values.emplace_back(datums);
  DRIFTWISE_TRY(auto evaluator, effects::TermEvaluator::create(terms, symbols));
  if (evaluator.has_memory() && dataset.time_s.empty())
    return fail(ErrorCode::invalid_argument, reasons::kUntimed,
                "the model has effects with memory: the data need a time_s column");
  if (std::ranges::any_of(terms, effects::reads_path) && says_overruns(dataset)) {
    WholePath whole = with_overruns(dataset);
    whole.data.metadata.clear();
    Eigen::MatrixXd along(static_cast<Eigen::Index>(whole.data.rows),
                          static_cast<Eigen::Index>(terms.size()));
    DRIFTWISE_RETURN_IF_ERROR(for_each_chunk(whole.data, terms, executor,
                                             [&](Eigen::Index at, const Eigen::MatrixXd& columns) {
                                               along.middleRows(at, columns.rows()) = columns;
                                             }));
    use(0, Eigen::MatrixXd(along(whole.kept, Eigen::all)));
    return {};
  }
  const auto evaluate = [&](effects::TermEvaluator& one, std::size_t number) {
    const std::size_t at = number * kPredictRows, count = std::min(kPredictRows, dataset.rows - at);
    std::vector<std::span<const double>> chunk;
    for (const auto& column : values) chunk.push_back(column.subspan(at, count));
    const auto times = dataset.time_s.empty() ? std::span<const double>()
                                              : std::span(dataset.time_s).subspan(at, count);
    use(static_cast<Eigen::Index>(at), one.block(times, chunk, count));
  };
  if (evaluator.has_memory()) {
    for (std::size_t i = 0; i < chunks_in(dataset); ++i) evaluate(evaluator, i);
    return {};
  }
  run_on(executor, chunks_in(dataset), [&](std::size_t i) {
    effects::TermEvaluator own = evaluator;
    evaluate(own, i);
  });
  return {};
}

}  // namespace

Eigen::VectorXd combine(const Eigen::MatrixXd& columns, const Eigen::VectorXd& coefficients) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(columns.rows());
  for (Eigen::Index j = 0; j < columns.cols(); ++j) sum += coefficients[j] * columns.col(j);
  return sum;
}

Result<Eigen::VectorXd> predict(const Dataset& dataset, const OutputModel& output,
                                const Executor& executor) {
  Eigen::VectorXd predicted(static_cast<Eigen::Index>(dataset.rows));
  DRIFTWISE_RETURN_IF_ERROR(for_each_chunk(
      dataset, output.terms, executor, [&](Eigen::Index at, const Eigen::MatrixXd& columns) {
        predicted.segment(at, columns.rows()) = combine(columns, output.coefficients);
      }));
  return predicted;
}

Result<PredictedRows> predict_and_range(const Dataset& dataset, const OutputModel& output,
                                        const std::vector<std::size_t>& rows,
                                        const Executor& executor) {
  PredictedRows result;
  result.output.resize(static_cast<Eigen::Index>(dataset.rows));
  struct Sums {
    double low = HUGE_VAL, high = -HUGE_VAL, sum = 0;
  };
  std::vector<std::vector<Sums>> chunks(chunks_in(dataset), std::vector<Sums>(output.terms.size()));
  DRIFTWISE_RETURN_IF_ERROR(for_each_chunk(
      dataset, output.terms, executor, [&](Eigen::Index at, const Eigen::MatrixXd& columns) {
        result.output.segment(at, columns.rows()) = combine(columns, output.coefficients);
        const auto first = static_cast<std::size_t>(at);
        const auto begin = std::ranges::lower_bound(rows, first);
        const auto end =
            std::lower_bound(begin, rows.end(), first + static_cast<std::size_t>(columns.rows()));
        for (std::size_t j = 0; j < output.terms.size(); ++j) {
          const double* column = columns.col(static_cast<Eigen::Index>(j)).data();
          Sums sums;
          for (auto row = begin; row != end; ++row) {
            const double value = column[*row - first];
            sums.low = std::min(sums.low, value);
            sums.high = std::max(sums.high, value);
            sums.sum += value;
          }
          chunks[first / kPredictRows][j] = sums;
        }
      }));
  for (std::size_t j = 0; j < output.terms.size(); ++j) {
    Sums all;
    for (const auto& chunk : chunks) {
      all.low = std::min(all.low, chunk[j].low);
      all.high = std::max(all.high, chunk[j].high);
      all.sum += chunk[j].sum;
    }
    result.terms.push_back({all.low, all.high, all.sum / static_cast<double>(rows.size())});
  }
  return result;
}

Result<Eigen::MatrixXd> raw_columns(const Dataset& dataset,
                                    const std::vector<effects::Term>& terms) {
  Eigen::MatrixXd all(static_cast<Eigen::Index>(dataset.rows),
                      static_cast<Eigen::Index>(terms.size()));
  DRIFTWISE_RETURN_IF_ERROR(
      for_each_chunk(dataset, terms, {}, [&](Eigen::Index at, const Eigen::MatrixXd& columns) {
        all.middleRows(at, columns.rows()) = columns;
      }));
  return all;
}

}  // namespace driftwise::calibration
