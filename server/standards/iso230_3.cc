#include "server/standards/iso230_3.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/standards/measured_columns.h"

namespace driftwise::standards {
namespace {

constexpr double kLeastShare = 0.9;  // of the test that a series spans
constexpr std::size_t kLeastVisits = 5;

std::string number_with(double value, const char* unit) {
  char text[48];
  std::snprintf(text, sizeof text, "%.6g %s", value, unit);
  return text;
}

tl::unexpected<Error> lacks_drift(Reason reason, const std::string& sentence) {
  return fail(ErrorCode::failed_precondition, reason, "ISO 230-3: " + sentence);
}

struct DriftSample {
  double time_s, e_nm;
};

std::vector<DriftSample> samples_of(const std::vector<Approach>& visits) {
  const double first_mm = visits.front().measured_mm - visits.front().target_mm;
  std::vector<DriftSample> out;
  for (const auto& visit : visits)
    out.push_back({visit.time_s, nm_from_mm(visit.measured_mm - visit.target_mm - first_mm)});
  return out;
}

// e at a time within the series, on the straight line between two visits. lacking() has refused
// gaps that are too long for that.
double e_at_nm(const std::vector<DriftSample>& samples, double time_s) {
  const auto after = std::ranges::lower_bound(samples, time_s, {}, &DriftSample::time_s);
  if (after->time_s == time_s) return after->e_nm;
  const auto before = after - 1;
  return std::lerp(before->e_nm, after->e_nm,
                   (time_s - before->time_s) / (after->time_s - before->time_s));
}

// The visits, and e at the other end of each window that begins or ends on a visit: where e is
// made of straight lines, its largest range in a window is between two of these.
std::vector<DriftSample> with_edges(const std::vector<DriftSample>& visits, double window_s) {
  auto samples = visits;
  for (const auto& visit : visits)
    for (const double edge_s : {visit.time_s - window_s, visit.time_s + window_s})
      if (edge_s > visits.front().time_s && edge_s < visits.back().time_s)
        samples.push_back({edge_s, e_at_nm(visits, edge_s)});
  std::ranges::stable_sort(samples, {}, &DriftSample::time_s);
  return samples;
}

// Largest range in any stretch of time of this length: one pass with the running extremes.
DriftWindow worst_window(const std::vector<DriftSample>& visits, double minutes, double start_s) {
  constexpr double kRounding_s = 1e-6;  // of an edge's time
  const double window_s = minutes * 60;
  const auto samples = with_edges(visits, window_s);
  DriftWindow out{minutes, 0, 0};
  std::deque<std::size_t> highest, lowest;  // falling and rising values of the present window
  std::size_t from = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    while (!highest.empty() && samples[highest.back()].e_nm <= samples[i].e_nm) highest.pop_back();
    while (!lowest.empty() && samples[lowest.back()].e_nm >= samples[i].e_nm) lowest.pop_back();
    highest.push_back(i);
    lowest.push_back(i);
    for (; samples[i].time_s - samples[from].time_s > window_s + kRounding_s; ++from) {
      if (highest.front() == from) highest.pop_front();
      if (lowest.front() == from) lowest.pop_front();
    }
    const double range_nm = samples[highest.front()].e_nm - samples[lowest.front()].e_nm;
    if (range_nm > out.range_nm) {
      out.range_nm = range_nm;
      out.from_h = (samples[from].time_s - start_s) / 3600;
    }
  }
  return out;
}

double slope_nm_per_h(const std::vector<DriftSample>& samples) {
  const auto n = static_cast<double>(samples.size());
  double mean_h = 0, mean_nm = 0;
  for (const auto& s : samples) {
    mean_h += s.time_s / 3600 / n;
    mean_nm += s.e_nm / n;
  }
  double both = 0, squares = 0;
  for (const auto& s : samples) {
    const double h = s.time_s / 3600 - mean_h;
    both += h * (s.e_nm - mean_nm);
    squares += h * h;
  }
  return squares > 0 ? both / squares : 0;
}

DriftSeries series_figures(const std::vector<Approach>& visits, const Iso2303Options& options,
                           double start_s) {
  const auto samples = samples_of(visits);
  DriftSeries out;
  out.target_mm = visits.front().target_mm;
  const bool at_rest =
      std::none_of(visits.begin() + 1, visits.end(), [](const auto& visit) { return visit.moved; });
  out.side = at_rest ? ApproachSide::unknown : visits.front().side;
  out.visits = samples.size();
  out.duration_h = (samples.back().time_s - samples.front().time_s) / 3600;
  const auto [low, high] = std::ranges::minmax(samples, {}, &DriftSample::e_nm);
  out.range_nm = high.e_nm - low.e_nm;
  out.at_end_nm = samples.back().e_nm;
  out.slope_nm_per_h = slope_nm_per_h(samples);
  if (const double hour_s = samples.front().time_s + 3600; hour_s <= samples.back().time_s)
    out.after_60_min_nm = e_at_nm(samples, hour_s);
  for (const double minutes : options.windows_min)
    if (minutes / 60 <= out.duration_h)
      out.windows.push_back(worst_window(samples, minutes, start_s));
  return out;
}

// What a series lacks, or nothing.
std::string lacking(const std::vector<Approach>& visits, const Iso2303Options& options,
                    double test_s) {
  if (visits.size() < kLeastVisits)
    return std::to_string(visits.size()) + " visits, expected at least " +
           std::to_string(kLeastVisits);
  const double span_s = visits.back().time_s - visits.front().time_s;
  if (span_s < kLeastShare * test_s)
    return "visits over " + number_with(span_s / 3600, "h") + ", expected nine tenths of " +
           number_with(test_s / 3600, "h");
  double gap_s = 0;
  for (std::size_t i = 1; i < visits.size(); ++i)
    gap_s = std::max(gap_s, visits[i].time_s - visits[i - 1].time_s);
  if (gap_s > options.longest_gap_min * 60)
    return "a gap of " + number_with(gap_s / 60, "min") + ", expected at most " +
           number_with(options.longest_gap_min, "min");
  return {};
}

// Returns to zero at the begin and the end, and a row that nothing led to, are no series that a
// test wants.
bool is_of_the_test(const std::vector<Approach>& visits) {
  if (visits.size() == 1 && visits.front().side == ApproachSide::unknown) return false;
  return std::ranges::any_of(visits, [](const Approach& visit) { return !visit.zero; });
}

const char* side_text(ApproachSide side) {
  return side == ApproachSide::up ? " from below" : side == ApproachSide::down ? " from above" : "";
}

std::string first_of(const std::vector<std::string>& sentences) {
  constexpr std::size_t kShown = 6;
  std::string text;
  for (std::size_t i = 0; i < std::min(sentences.size(), kShown); ++i)
    text += (i > 0 ? "; " : "") + sentences[i];
  if (sentences.size() > kShown)
    text += "; and " + std::to_string(sentences.size() - kShown) + " more";
  return text;
}

Result<void> check_options(const Iso2303Options& options) {
  const auto is_duration = [](double value) { return std::isfinite(value) && value > 0; };
  const auto refuse = [](const char* what, double found, const char* unit) {
    return fail(ErrorCode::invalid_argument, reasons::kOutOfRange,
                std::string(what) + ": found " + number_with(found, unit) +
                    ", expected a duration above 0");
  };
  if (!is_duration(options.hours)) return refuse("hours", options.hours, "h");
  if (!is_duration(options.longest_gap_min))
    return refuse("longest_gap_min", options.longest_gap_min, "min");
  if (options.windows_min.size() > kMostWindows)
    return fail(ErrorCode::invalid_argument, reasons::kOutOfRange,
                "windows_min: found " + std::to_string(options.windows_min.size()) +
                    " of them, expected at most " + std::to_string(kMostWindows));
  for (const double minutes : options.windows_min)
    if (!is_duration(minutes)) return refuse("windows_min", minutes, "min");
  return {};
}

}  // namespace

Result<Iso2303> iso230_3(const Dataset& dataset, const Iso2303Options& options) {
  DRIFTWISE_RETURN_IF_ERROR(check_options(options));
  DRIFTWISE_TRY(const auto columns, find_axis_columns(dataset, options.columns));
  if (dataset.time_s.empty())
    return lacks_drift(reasons::kUntimed, "needs the time of each row (time_s), found none");
  DRIFTWISE_TRY(const auto approaches, approaches_of(dataset, columns));
  const auto span = time_span(dataset);
  const double start_s = span.first_s, test_s = span.last_s - start_s;
  if (test_s < options.hours * 3600)
    return lacks_drift(reasons::kTooShort,
                       "needs " + number_with(options.hours, "h") + ", found " +
                           number_with(test_s / 3600, "h") +
                           ". `driftwise trajectory iso230-3` writes a trajectory "
                           "that lasts, --hours allows a shorter test");
  Iso2303 out;
  out.columns = columns;
  std::vector<std::string> lacks, left_out;  // of all; of those that the test wants
  constexpr bool kWithReturns = true;
  for (const auto& position : positions_of(approaches, kWithReturns))
    for (const auto* visits : {&position.up, &position.down, &position.unknown}) {
      if (visits->empty()) continue;
      const std::string lack = lacking(*visits, options, test_s);
      if (lack.empty()) {
        out.series.push_back(series_figures(*visits, options, start_s));
        out.range_nm = std::max(out.range_nm, out.series.back().range_nm);
      } else {
        lacks.push_back(number_with(position.target_mm, "mm") + side_text(visits->front().side) +
                        " has " + lack);
        if (is_of_the_test(*visits)) left_out.push_back(lacks.back());
      }
    }
  if (out.series.empty())
    return lacks_drift(reasons::kNoSeries,
                       "needs a position that is visited from one side all through the test: " +
                           (lacks.empty() ? "found no measured row" : first_of(lacks)) +
                           ". `driftwise trajectory iso230-3` writes a trajectory that has them");
  if (!left_out.empty())
    out.warnings.push_back(std::to_string(left_out.size()) +
                           " series of visits are in no figure: " + first_of(left_out));
  out.conditions = conditions_of(dataset);
  if (const std::size_t datums = datum_count(dataset); datums > 1)
    out.warnings.push_back("the rows lie in " + std::to_string(datums) +
                           " datums: a new zero in between is part of the drift");
  return out;
}

}  // namespace driftwise::standards
