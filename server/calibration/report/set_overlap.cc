#include "server/calibration/report/set_overlap.h"

#include <bit>
#include <unordered_map>

#include "server/core/reasons.h"

namespace driftwise::calibration {
namespace {

bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

// Rows of another time or run are another measurement, whatever a coarse display shows.
bool same_measurement(const Dataset& dataset, std::size_t a, std::size_t b) {
  if (!dataset.run.empty() && dataset.run[a] != dataset.run[b]) return false;
  if (!dataset.time_s.empty() && !same(dataset.time_s[a], dataset.time_s[b])) return false;
  for (const auto& column : dataset.columns)
    if (!same(column.values[a], column.values[b])) return false;
  return true;
}

}  // namespace

Result<void> check_sets_apart(const Dataset& dataset, const Design& design) {
  if (design.validation == 0 || design.outputs.empty()) return {};
  // By the first output alone; what it cannot tell apart is compared in full.
  const auto& key = dataset.find(design.outputs.front().symbol)->values;
  std::unordered_multimap<std::uint64_t, std::size_t> calibration;
  calibration.reserve(design.rows.size());
  for (const std::size_t row : design.rows)
    calibration.emplace(std::bit_cast<std::uint64_t>(key[row]), row);
  std::size_t count = 0, first_calibration = 0, first_validation = 0;
  for (std::size_t row = 0; row < dataset.rows; ++row) {
    if (dataset.set_of(row) != PointSet::validation || dataset.is_excluded(row)) continue;
    const auto [begin, end] = calibration.equal_range(std::bit_cast<std::uint64_t>(key[row]));
    int looked_at = 0;  // a coarse output alone must not make this slow
    for (auto one = begin; one != end && looked_at < 64; ++one, ++looked_at) {
      if (!same_measurement(dataset, one->second, row)) continue;
      if (count++ == 0) {
        first_calibration = one->second;
        first_validation = row;
      }
      break;
    }
  }
  if (count == 0) return {};
  return fail(ErrorCode::failed_precondition, reasons::kSetsOverlap,
              std::to_string(count) + " of " + std::to_string(design.validation) +
                  " validation rows repeat a calibration row in every channel" +
                  (dataset.time_s.empty() ? "" : " and its time") + " (first: row " +
                  std::to_string(first_validation + 1) + " is row " +
                  std::to_string(first_calibration + 1) +
                  "): the model would be judged on rows it was fitted to; give each measurement to "
                  "one set");
}

}  // namespace driftwise::calibration
