#include "server/calibration/predict.h"

#include <algorithm>

#include "server/calibration/design.h"
#include "server/effects/term_evaluator.h"
#include "server/effects/term_order.h"

namespace driftwise::calibration {
namespace {

constexpr std::size_t kChunkRows = 4096;

// Feeds the rows through the evaluator in chunks; use(first row, columns).
template <class Use>
Result<void> for_each_chunk(const Dataset& dataset, const std::vector<effects::Term>& terms,
                            Use use) {
  std::vector<std::string> symbols;
  for (const auto& term : terms)
    for (const auto& symbol : effects::symbols_of(term))
      if (std::ranges::find(symbols, symbol) == symbols.end()) symbols.push_back(symbol);
  std::vector<std::span<const double>> values;
  for (const auto& symbol : symbols) {
    const auto column = dataset.values_of(symbol);
    if (column.empty())
      return fail(ErrorCode::invalid_argument, "UNKNOWN_CHANNEL",
                  "the model needs channel '" + symbol + "', which the data lack");
    values.emplace_back(column);
  }
  const std::vector<double> datums = datum_ordinals(dataset);
  symbols.push_back("datum");
  values.emplace_back(datums);
  auto evaluator = effects::TermEvaluator::create(terms, symbols);
  if (!evaluator) return tl::unexpected(evaluator.error());
  if (evaluator->has_memory() && dataset.time_s.empty())
    return fail(ErrorCode::invalid_argument, "UNTIMED",
                "the model has effects with memory: the data need a time_s column");
  std::vector<std::span<const double>> chunk(values.size());
  for (std::size_t at = 0; at < dataset.rows; at += kChunkRows) {
    const std::size_t count = std::min(kChunkRows, dataset.rows - at);
    for (std::size_t c = 0; c < values.size(); ++c) chunk[c] = values[c].subspan(at, count);
    const auto times = dataset.time_s.empty() ? std::span<const double>()
                                              : std::span(dataset.time_s).subspan(at, count);
    use(static_cast<Eigen::Index>(at), evaluator->block(times, chunk, count));
  }
  return {};
}

}  // namespace

Eigen::VectorXd combine(const Eigen::MatrixXd& columns, const Eigen::VectorXd& coefficients) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(columns.rows());
  for (Eigen::Index j = 0; j < columns.cols(); ++j) sum += coefficients[j] * columns.col(j);
  return sum;
}

Result<Eigen::VectorXd> predict(const Dataset& dataset, const OutputModel& output) {
  Eigen::VectorXd predicted(static_cast<Eigen::Index>(dataset.rows));
  const auto done =
      for_each_chunk(dataset, output.terms, [&](Eigen::Index at, const Eigen::MatrixXd& columns) {
        predicted.segment(at, columns.rows()) = combine(columns, output.coefficients);
      });
  if (!done) return tl::unexpected(done.error());
  return predicted;
}

Result<Eigen::MatrixXd> raw_columns(const Dataset& dataset,
                                    const std::vector<effects::Term>& terms) {
  Eigen::MatrixXd all(static_cast<Eigen::Index>(dataset.rows),
                      static_cast<Eigen::Index>(terms.size()));
  const auto done =
      for_each_chunk(dataset, terms, [&](Eigen::Index at, const Eigen::MatrixXd& columns) {
        all.middleRows(at, columns.rows()) = columns;
      });
  if (!done) return tl::unexpected(done.error());
  return all;
}

}  // namespace driftwise::calibration
