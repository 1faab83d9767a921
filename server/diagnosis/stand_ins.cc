#include "server/diagnosis/stand_ins.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <iterator>

#include "server/diagnosis/rows/predicted_pose.h"
#include "server/effects/term_order.h"

namespace driftwise::diagnosis {
namespace {

constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"}, kMotors = {"q1", "q2", "q3"};

bool varies(const DatasetColumn& column) {
  return std::ranges::adjacent_find(column.values, std::ranges::not_equal_to{}) !=
         column.values.end();
}

// Columns of one kind of coordinate that say where the machine was sent.
std::vector<const DatasetColumn*> places(const Dataset& dataset, bool motors, bool angles,
                                         const std::vector<std::string>& outputs) {
  std::vector<const DatasetColumn*> result;
  for (const auto& column : dataset.columns) {
    const auto& [symbol, unit] = column.channel;
    if (motors ? !is_motor_symbol(symbol) : !is_pose_symbol(symbol)) continue;
    if (angles ? !is_angle(unit) : !is_length(unit)) continue;
    if (!varies(column) || std::ranges::find(outputs, symbol) != outputs.end()) continue;
    if (!motors && !repeats_exactly(dataset, column.values)) continue;
    result.push_back(&column);
  }
  return result;
}

bool has_any(const Dataset& dataset, const std::vector<std::string>& but,
             bool (*is_one)(std::string_view), bool (*of)(std::string_view)) {
  return std::ranges::any_of(dataset.columns, [&](const DatasetColumn& column) {
    const auto& [symbol, unit] = column.channel;
    return is_one(symbol) && of(unit) && varies(column) &&
           std::ranges::find(but, symbol) == but.end();
  });
}

double range_nm(const DatasetColumn& column) {
  double low = INFINITY, high = -INFINITY;
  for (const double value : column.values)
    if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
  return high > low ? (high - low) * summary_unit(column.channel.unit).factor : 0;
}

bool reads(const calibration::Candidates& baseline, const std::string& symbol) {
  return std::ranges::any_of(baseline.terms, [&](const effects::Term& term) {
    const auto symbols = effects::symbols_of(term);
    return std::ranges::find(symbols, symbol) != symbols.end();
  });
}

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

class Renaming {
 public:
  explicit Renaming(const std::vector<std::pair<std::string, std::string>>& names)
      : names_(names) {}

  void operator()(std::string& text) const {
    std::string result;
    for (std::size_t i = 0; i < text.size();) {
      std::size_t end = i;
      while (end < text.size() && is_word(text[end])) ++end;
      if (end == i) {
        result += text[i++];
        continue;
      }
      result += own(text.substr(i, end - i));
      i = end;
    }
    text = std::move(result);
  }

  void operator()(effects::Term& term) const {
    for (auto& factor : term.factors)
      if (auto* power = std::get_if<effects::Power>(&factor))
        power->symbol = own(power->symbol);
      else
        for (auto& symbol : std::get<effects::Call>(factor).symbols) symbol = own(symbol);
  }

  bool stands_in(const std::string& symbol) const { return own(symbol) != symbol; }

 private:
  std::string own(const std::string& symbol) const {
    const auto found =
        std::ranges::find(names_, symbol, &std::pair<std::string, std::string>::first);
    return found == names_.end() ? symbol : found->second;
  }

  const std::vector<std::pair<std::string, std::string>>& names_;
};

}  // namespace

std::vector<std::string> deviations_of(const Dataset& dataset,
                                       const calibration::Candidates& baseline) {
  constexpr double kOfAnAxis = 1e-3;
  double longest = 0;
  for (const auto& column : dataset.columns)
    if (const auto& symbol = column.channel.symbol;
        is_length(column.channel.unit) && (is_motor_symbol(symbol) || is_pose_symbol(symbol)))
      longest = std::max(longest, range_nm(column));
  std::vector<std::string> result;
  for (const auto& column : dataset.columns) {
    const auto& [symbol, unit] = column.channel;
    if (!is_pose_symbol(symbol) || !is_length(unit) || !(range_nm(column) < kOfAnAxis * longest))
      continue;
    const bool output = std::ranges::find(baseline.outputs, symbol) != baseline.outputs.end();
    if (output || (!reads(baseline, symbol) && !repeats_exactly(dataset, column.values)))
      result.push_back(symbol);
  }
  return result;
}

std::optional<StandIns> stand_ins(const Dataset& dataset, const DiagnoseOptions& options) {
  const auto& outputs = options.baseline.outputs;
  if (std::ranges::any_of(outputs, is_motor_symbol)) return std::nullopt;
  const auto strays = deviations_of(dataset, options.baseline);
  const bool motors = has_any(dataset, {}, is_motor_symbol, is_length) ||
                      has_any(dataset, {}, is_motor_symbol, is_angle);
  const bool lengths = has_any(dataset, strays, is_pose_symbol, is_length),
             angles = has_any(dataset, {}, is_pose_symbol, is_angle);
  if (motors && lengths) return std::nullopt;
  auto own = places(dataset, motors, false, outputs);
  const bool turns = own.empty();
  if (turns) own = places(dataset, motors, true, outputs);
  if (own.empty() || own.size() > (turns ? 1 : kAxes.size())) return std::nullopt;
  if (motors && turns && angles) return std::nullopt;
  std::vector<const char*> names;
  if (!motors)
    names.assign(kMotors.begin(), kMotors.end());
  else if (turns)
    names = {"rz"};
  else
    std::ranges::copy_if(kAxes, std::back_inserter(names),
                         [&](const char* axis) { return dataset.find(axis) == nullptr; });
  if (own.size() > names.size()) return std::nullopt;
  StandIns result{dataset, options, {}};
  auto& excluded = result.options.exclude_symbols;
  for (std::size_t k = 0; k < own.size(); ++k) {
    const char* stand = names[k];
    result.names.emplace_back(stand, own[k]->channel.symbol);
    result.data.columns.push_back({{stand, own[k]->channel.unit}, own[k]->values});
    if (std::ranges::find(excluded, own[k]->channel.symbol) != excluded.end())
      excluded.emplace_back(stand);
  }
  if (!motors) return result;
  std::vector<std::pair<std::string, std::string>> to_pose;
  for (const auto& [stand, symbol] : result.names) to_pose.emplace_back(symbol, stand);
  const Renaming renamed(to_pose);
  for (auto& term : result.options.baseline.terms) renamed(term);
  return result;
}

void name_as_in_file(const StandIns& stand_ins, Diagnosis& diagnosis) {
  const Renaming renamed(stand_ins.names);
  renamed(diagnosis.extended_formula);
  for (auto& text : diagnosis.warnings) renamed(text);
  for (auto& one : diagnosis.not_testable) renamed(one.cause), renamed(one.why);
  for (auto& one : diagnosis.left_over) renamed(one.goes_with);
  for (auto& output : diagnosis.outputs)
    std::erase_if(output.explained_by,
                  [&](const Share& share) { return renamed.stands_in(share.variable); });
  for (auto& finding : diagnosis.findings) {
    renamed(finding.subject);
    renamed(finding.sentence);
    for (auto& rival : finding.indistinguishable_from) renamed(rival);
    for (auto& term : finding.terms) renamed(term);
  }
}

}  // namespace driftwise::diagnosis
