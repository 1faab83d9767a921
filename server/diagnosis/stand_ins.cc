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

// In the summary unit: nm, arcsec.
double range_of(const DatasetColumn& column) {
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

bool is_output(const calibration::Candidates& baseline, const std::string& symbol) {
  return std::ranges::find(baseline.outputs, symbol) != baseline.outputs.end();
}

// A coordinate by its unit, whose name says no role. "_cmd", "_std": of another channel's; a dot:
// of a robot, whose names are its cell's.
bool is_own_name(const Channel& channel) {
  const std::string& symbol = channel.symbol;
  return (is_length(channel.unit) || is_angle(channel.unit)) && !is_motor_symbol(symbol) &&
         !is_pose_symbol(symbol) && symbol.find('.') == std::string::npos &&
         !symbol.ends_with("_cmd") && !symbol.ends_with("_std") && !symbol.ends_with("_set");
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

  // Of a number's name: "offset_mm_rx_q1".
  std::string in_parts(const std::string& name) const {
    std::string result;
    for (std::size_t at = 0; at <= name.size();) {
      const std::size_t end = std::min(name.find('_', at), name.size());
      result += (at > 0 ? "_" : "") + own(name.substr(at, end - at));
      at = end + 1;
    }
    return result;
  }

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
      longest = std::max(longest, range_of(column));
  std::vector<std::string> result;
  for (const auto& column : dataset.columns) {
    const auto& [symbol, unit] = column.channel;
    if (!is_pose_symbol(symbol) || !is_length(unit) || !(range_of(column) < kOfAnAxis * longest))
      continue;
    const bool output = std::ranges::find(baseline.outputs, symbol) != baseline.outputs.end();
    if (output || (!reads(baseline, symbol) && !repeats_exactly(dataset, column.values)))
      result.push_back(symbol);
  }
  return result;
}

std::optional<StandIns> stand_ins(const Dataset& dataset, const DiagnoseOptions& options) {
  if (auto named = in_names_of_coordinates(dataset, options)) return named;
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

namespace {

// Sizes that tell a coordinate from a deviation or a tilt of one.
struct Largest {
  double length_nm = 0, angle_arcsec = 0;

  // Of all that the baseline reads and predicts.
  Largest(const Dataset& dataset, const calibration::Candidates& baseline) {
    for (const auto& column : dataset.columns) {
      const auto& [symbol, unit] = column.channel;
      if (!is_output(baseline, symbol) && !reads(baseline, symbol)) continue;
      if (is_length(unit)) length_nm = std::max(length_nm, range_of(column));
      if (is_angle(unit)) angle_arcsec = std::max(angle_arcsec, range_of(column));
    }
  }

  bool is_coordinate(const DatasetColumn& column) const {
    constexpr double kOfLargest = 0.05, kLeastTurn_arcsec = 3600;
    const double range = range_of(column);
    if (is_length(column.channel.unit)) return range >= kOfLargest * length_nm;
    return range >= kOfLargest * angle_arcsec && (length_nm == 0 || range >= kLeastTurn_arcsec);
  }
};

}  // namespace

std::optional<StandIns> in_names_of_coordinates(const Dataset& dataset,
                                                const DiagnoseOptions& options) {
  const auto& baseline = options.baseline;
  const bool pose_is_asked = std::ranges::any_of(baseline.outputs, is_pose_symbol);
  // The pose from the motors, and not the other way round.
  const bool forward =
      pose_is_asked || std::ranges::any_of(dataset.columns, [&](const DatasetColumn& column) {
        return is_motor_symbol(column.channel.symbol) && reads(baseline, column.channel.symbol);
      });
  const Largest largest(dataset, baseline);
  // An output alone is what an instrument reads, of a motor or not.
  const bool any_read = std::ranges::any_of(dataset.columns, [&](const DatasetColumn& column) {
    return reads(baseline, column.channel.symbol) && varies(column) &&
           (is_length(column.channel.unit) || is_angle(column.channel.unit)) &&
           largest.is_coordinate(column);
  });
  if (!any_read) return std::nullopt;
  StandIns result{dataset, options, {}, true, {}};
  std::vector<std::pair<std::string, std::string>> to_names;
  for (auto& column : result.data.columns) {
    const Channel channel = column.channel;
    const bool output = is_output(baseline, channel.symbol), length = is_length(channel.unit);
    if (!is_own_name(channel) || !(output || reads(baseline, channel.symbol)) || !varies(column) ||
        !largest.is_coordinate(column) || (output && pose_is_asked))
      continue;
    std::vector<std::string> names = {"x", "y", "z"};
    if (!length) names = {"rx", "ry", "rz"};
    if (!length && largest.length_nm == 0) names = {"rz", "rx", "ry"};
    if (output != forward) {
      names.clear();
      for (std::size_t n = 1; n <= dataset.columns.size(); ++n)
        names.push_back("q" + std::to_string(n));
    }
    const auto free = std::ranges::find_if(
        names, [&](const std::string& name) { return result.data.find(name) == nullptr; });
    if (free == names.end()) {
      result.nameless.push_back(channel.symbol);
      continue;
    }
    result.names.emplace_back(*free, channel.symbol);
    to_names.emplace_back(channel.symbol, *free);
    column.channel.symbol = *free;
  }
  if (result.names.empty()) return std::nullopt;
  const Renaming renamed(to_names);
  for (auto& term : result.options.baseline.terms) renamed(term);
  for (auto& output : result.options.baseline.outputs) renamed(output);
  for (auto& symbol : result.options.exclude_symbols) renamed(symbol);
  return result;
}

std::vector<std::string> unread_coordinates(const Dataset& dataset,
                                            const DiagnoseOptions& options) {
  const auto& outputs = options.baseline.outputs;
  std::vector<std::string> said;
  for (const auto& column : dataset.columns) {
    const Channel& channel = column.channel;
    const bool of_an_output = std::ranges::any_of(outputs, [&](const std::string& output) {
      return channel.symbol == output || channel.symbol.starts_with(output + "_");
    });
    if (!is_own_name(channel) || of_an_output || reads(options.baseline, channel.symbol) ||
        !varies(column) ||
        std::ranges::find(options.exclude_symbols, channel.symbol) != options.exclude_symbols.end())
      continue;
    said.push_back("no cause reads " + channel.symbol + " (" + channel.unit +
                   "): its name gives it no role. Where it is a coordinate of the robot or a tilt, "
                   "name it as one (docs/diagnosis.md, stage 1), and diagnose again");
  }
  return said;
}

namespace {

std::string roles_sentence(const StandIns& stand_ins) {
  std::string said = "by their places in the formula ";
  for (std::size_t i = 0; i < stand_ins.names.size(); ++i) {
    const auto& [name, own] = stand_ins.names[i];
    said += (i == 0 ? "" : ", ") + own + " counts as " + name +
            (is_motor_symbol(name) ? " (a motor's place)" : " (a coordinate of the pose)");
  }
  return said + ": rename the columns where that is wrong";
}

}  // namespace

void name_as_in_file(const StandIns& stand_ins, Diagnosis& diagnosis) {
  const Renaming renamed(stand_ins.names);
  renamed(diagnosis.extended_formula);
  for (auto& text : diagnosis.warnings) renamed(text);
  for (auto& one : diagnosis.not_testable) renamed(one.cause), renamed(one.why);
  for (auto& one : diagnosis.left_over) renamed(one.goes_with);
  if (stand_ins.replaced) renamed(diagnosis.baseline_formula);
  for (auto& output : diagnosis.outputs) {
    if (stand_ins.replaced) {
      renamed(output.output);
      for (auto& share : output.explained_by) renamed(share.variable);
      continue;
    }
    std::erase_if(output.explained_by,
                  [&](const Share& share) { return renamed.stands_in(share.variable); });
  }
  for (auto& finding : diagnosis.findings) {
    renamed(finding.subject);
    renamed(finding.sentence);
    for (auto& rival : finding.indistinguishable_from) renamed(rival);
    for (auto& term : finding.terms) renamed(term);
    if (!stand_ins.replaced) continue;
    for (auto& parameter : finding.parameters) parameter.name = renamed.in_parts(parameter.name);
    for (auto& output : finding.outputs) renamed(output.output);
  }
  if (stand_ins.replaced) diagnosis.warnings.push_back(roles_sentence(stand_ins));
  for (const auto& symbol : stand_ins.nameless) {
    const std::string why = symbol +
                            " was taken for no coordinate: more lengths or angles are "
                            "read than a pose has (x, y, z, rx, ry, rz)";
    diagnosis.warnings.push_back(why + ". No cause and no test of what is left goes with it");
    for (const char* cause : {"cyclic_error", "geometry_order", "thermal_expansion"})
      diagnosis.not_testable.push_back({cause, why});
  }
}

}  // namespace driftwise::diagnosis
