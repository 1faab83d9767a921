#include "clients/cli/commands/models/validation_file.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "clients/cli/core/console.h"
#include "server/core/cell_time.h"
#include "server/core/data/reading.h"
#include "server/effects/effect.h"

namespace driftwise::cli {
namespace {

struct NamedData {
  const Dataset& data;
  const std::string& name;
};

[[noreturn]] void refuse_pair(const std::string& reason, const std::string& message) {
  throw Failure{ExitCode::bad_input, "invalid_argument", reason, message};
}

std::optional<double> time_zero_s(const Dataset& data) {
  for (const auto& [key, value] : data.metadata)
    if (key == "time_zero")
      if (const auto at = parse_iso8601(value)) return static_cast<double>(at->utc_ns) * 1e-9;
  return std::nullopt;
}

// What is added to the second file's time_s.
double time_shift_s(const Dataset& first, const Dataset& second) {
  const auto zero = time_zero_s(first), other = time_zero_s(second);
  if (zero && other) return *other - *zero;
  if (first.time_s.empty() || second.time_s.empty()) return 0;
  return std::max(0.0, first.time_s.back() - second.time_s.front());
}

bool is_same(double a, double b) { return a == b || (is_missing(a) && is_missing(b)); }

// A row of the second file that is one of the first, by its own time and every channel. Joined, it
// has another time. Files that both say when they began are compared by that.
void refuse_the_same_rows(const NamedData& first, const NamedData& second) {
  if (time_zero_s(first.data) && time_zero_s(second.data)) return;
  std::map<double, std::size_t> row_at;
  for (std::size_t row = 0; row < first.data.time_s.size(); ++row)
    row_at.emplace(first.data.time_s[row], row);
  std::size_t count = 0;
  for (std::size_t row = 0; row < second.data.time_s.size(); ++row) {
    const auto at = row_at.find(second.data.time_s[row]);
    if (at == row_at.end()) continue;
    count += std::ranges::all_of(first.data.columns, [&](const DatasetColumn& column) {
      const auto* other = second.data.find(column.channel.symbol);
      return other != nullptr && is_same(other->values[row], column.values[at->second]);
    });
  }
  if (count > 0)
    refuse_pair("SETS_OVERLAP", std::to_string(count) + " rows of " + second.name +
                                    " are rows of " + first.name +
                                    ", by their times and every channel: the model would be judged "
                                    "on rows it was fitted to; give those of another campaign, or "
                                    "say when each began ('# time_zero: 2026-11-30T08:00:00Z')");
}

void check_pair(const NamedData& first, const NamedData& second) {
  for (std::size_t row = 0; row < first.data.rows; ++row)
    if (first.data.set_of(row) == PointSet::validation && !first.data.is_excluded(row))
      refuse_pair("VALIDATION_TWICE",
                  first.name + " marks validation rows itself (the first is row " +
                      std::to_string(row + 1) + "): leave --validation " + second.name +
                      " out, or keep those rows out with --exclude-rows");
  if (first.data.time_s.empty() != second.data.time_s.empty())
    refuse_pair("TIME_IN_ONE_FILE", (first.data.time_s.empty() ? second.name : first.name) +
                                        " has time_s, " +
                                        (first.data.time_s.empty() ? first.name : second.name) +
                                        " has not: give both of them times, or neither");
  for (const auto& column : first.data.columns) {
    const auto* other = second.data.find(column.channel.symbol);
    if (other != nullptr && other->channel.unit != column.channel.unit)
      refuse_pair("UNITS_DISAGREE", column.channel.symbol + " is in " + column.channel.unit +
                                        " in " + first.name + " and in " + other->channel.unit +
                                        " in " + second.name + ": give both in one unit");
  }
  refuse_the_same_rows(first, second);
}

// Numbers of runs or of datums over both files; empty: neither has any.
std::vector<std::int64_t> joined_numbers(const std::vector<std::int64_t>& first,
                                         const std::vector<std::int64_t>& second,
                                         const NamedData& one, const NamedData& other,
                                         const char* what) {
  if (first.empty() && second.empty()) return {};
  const auto filled = [&](const std::vector<std::int64_t>& has, const NamedData& with,
                          const NamedData& without) {
    const std::set<std::int64_t> distinct(has.begin(), has.end());
    if (distinct.size() != 1)
      refuse_pair("WHICH_DATUM", with.name + " has " + std::to_string(distinct.size()) +
                                     " numbers in column " + what + ", " + without.name +
                                     " does not say which its rows belong to: add the column " +
                                     what);
    return std::vector<std::int64_t>(without.data.rows, *distinct.begin());
  };
  auto all = first.empty() ? filled(second, other, one) : first;
  const auto rest = second.empty() ? filled(first, one, other) : second;
  all.insert(all.end(), rest.begin(), rest.end());
  return all;
}

// Fields that say nothing about a row which has none.
template <class T>
std::vector<T> joined_or(const std::vector<T>& first, const std::vector<T>& second,
                         const NamedData& one, const NamedData& other, T nothing) {
  if (first.empty() && second.empty()) return {};
  auto all = first.empty() ? std::vector<T>(one.data.rows, nothing) : first;
  const auto rest = second.empty() ? std::vector<T>(other.data.rows, nothing) : second;
  all.insert(all.end(), rest.begin(), rest.end());
  return all;
}

bool call_depends_on_times(const effects::Call& call) {
  const auto* kind = effects::find_effect(call.effect);
  return kind != nullptr &&
         (kind->in_data_time || kind->observes_path ||
          std::ranges::any_of(kind->parameters, [](const auto& one) { return one.unit == "s"; }));
}

}  // namespace

bool times_are_related(const Dataset& calibration, const Dataset& validation) {
  if (calibration.time_s.empty() || validation.time_s.empty()) return true;
  return time_zero_s(calibration) && time_zero_s(validation);
}

bool depends_on_times(const effects::Term& term) {
  return std::ranges::any_of(term.factors, [](const effects::Factor& factor) {
    const auto* call = std::get_if<effects::Call>(&factor);
    return call != nullptr && call_depends_on_times(*call);
  });
}

Dataset with_validation_rows(const Dataset& calibration, const std::string& calibration_name,
                             const Dataset& validation, const std::string& validation_name) {
  const NamedData first{calibration, calibration_name}, second{validation, validation_name};
  check_pair(first, second);
  const double shift_s = time_shift_s(calibration, validation);
  // Measured before the first: it stands before it, so that time goes on growing.
  const bool leads = !calibration.time_s.empty() && validation.rows > 0 &&
                     validation.time_s.back() + shift_s <= calibration.time_s.front();
  const NamedData& one = leads ? second : first;
  const NamedData& other = leads ? first : second;

  Dataset all;
  all.metadata = calibration.metadata;
  all.rows = calibration.rows + validation.rows;
  const auto& a = one.data;
  const auto& b = other.data;
  all.set.assign(a.rows, leads ? PointSet::validation : PointSet::calibration);
  all.set.resize(all.rows, leads ? PointSet::calibration : PointSet::validation);
  all.line = joined_or<std::int64_t>(a.line, b.line, one, other, 1);
  all.zero = joined_or<std::uint8_t>(a.zero, b.zero, one, other, 0);
  all.dwell_s = joined_or<double>(a.dwell_s, b.dwell_s, one, other, kMissing);
  all.excluded = joined_or<std::uint8_t>(a.excluded, b.excluded, one, other, 0);
  all.run = joined_numbers(a.run, b.run, one, other, "run");
  all.datum = joined_numbers(a.datum, b.datum, one, other, "datum");
  for (const auto* data : {&a, &b})
    for (const double time_s : data->time_s)
      all.time_s.push_back(time_s + (data == &validation ? shift_s : 0));
  for (std::size_t row = 1; row < all.time_s.size(); ++row)
    if (all.time_s[row] < all.time_s[row - 1])
      refuse_pair("TIMES_OVERLAP", calibration_name + " and " + validation_name +
                                       " were measured at the same time, by their time_zero: one "
                                       "has to end before the other begins");
  for (const auto& column : calibration.columns) {
    auto& joined = all.columns.emplace_back(DatasetColumn{column.channel, {}});
    for (const auto* data : {&a, &b}) {
      const auto* from = data->find(column.channel.symbol);
      if (from != nullptr)
        joined.values.insert(joined.values.end(), from->values.begin(), from->values.end());
      else
        joined.values.insert(joined.values.end(), data->rows, kMissing);
    }
  }
  return all;
}

}  // namespace driftwise::cli
