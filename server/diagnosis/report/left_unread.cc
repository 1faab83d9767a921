#include "server/diagnosis/report/left_unread.h"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <variant>
#include <vector>

#include "server/calibration/design/predict.h"
#include "server/calibration/linear/undetermined.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

std::string plain(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}

struct Range {
  std::string symbol, unit;
  double least = 0, most = 0;  // of the rows that are learned from
};

// Channels that the term has powers of.
std::vector<Range> ranges(const Problem& problem, const effects::Term& term) {
  std::vector<Range> result;
  for (const auto& factor : term.factors) {
    const auto* power = std::get_if<effects::Power>(&factor);
    const auto* column = power == nullptr ? nullptr : problem.data().find(power->symbol);
    if (column == nullptr || problem.learn.empty()) continue;
    Range range{power->symbol, column->channel.unit, column->values[problem.learn.front()],
                column->values[problem.learn.front()]};
    for (const std::size_t row : problem.learn) {
      range.least = std::min(range.least, column->values[row]);
      range.most = std::max(range.most, column->values[row]);
    }
    result.push_back(std::move(range));
  }
  return result;
}

// Is the term determined where these channels count from their least value?
bool told_apart_from(const std::vector<Range>& ranges, const Problem& problem,
                     const effects::Term& term) {
  Dataset shifted = problem.data();
  for (const auto& range : ranges)
    for (auto& column : shifted.columns)
      if (column.channel.symbol == range.symbol)
        for (double& value : column.values) value -= range.least;
  auto terms = problem.base;
  terms.push_back(term);
  const auto columns = calibration::raw_columns(shifted, terms);
  return columns && calibration::undetermined(rows_of(*columns, problem.learn), 1).back() == 0;
}

}  // namespace

std::string undetermined_note(const Problem& problem, const effects::Term& term) {
  const std::string left_out = effects::notation(term) + " of the baseline is left out: ";
  const auto read = ranges(problem, term);
  for (const auto& range : read)
    if (range.least == range.most)
      return left_out + range.symbol + " is " + plain(range.least) + " " + range.unit +
             " in every row that it learns from";
  if (read.empty() || !told_apart_from(read, problem, term))
    return left_out + "the rows that it learns from do not tell it apart from the terms before it";
  std::string far, subtract;
  for (const auto& range : read) {
    far += (far.empty() ? "" : " and ") + range.symbol + " is " + plain(range.least) + " to " +
           plain(range.most) + " " + range.unit;
    subtract += (subtract.empty() ? "subtract " : " and ") + plain(range.least) + " " + range.unit +
                " from " + range.symbol;
  }
  return left_out + far + ", so far from zero that it looks the same as the terms before it; " +
         subtract + " in the file";
}

std::string unread_pose_note(const Dataset& dataset, const kinematics::Mechanism& mechanism) {
  if (!mechanism.predicts_pose()) return "";
  const auto listed = [](const std::vector<std::string>& symbols) {
    std::string text;
    for (const auto& symbol : symbols) text += (text.empty() ? "" : ", ") + symbol;
    return text;
  };
  std::vector<std::string> predicted, unread;
  for (const auto& output : mechanism.outputs()) predicted.push_back(output.symbol);
  for (const auto& column : dataset.columns)
    if (const auto& symbol = column.channel.symbol;
        is_pose_symbol(symbol) && std::ranges::find(predicted, symbol) == predicted.end())
      unread.push_back(symbol);
  if (unread.empty()) return "";
  return "not used: " + listed(unread) + "; an arm is compared with its drawing in " +
         listed(predicted) + " only";
}

}  // namespace driftwise::diagnosis
