#include "server/application/models/run_to_check.h"

#include <algorithm>
#include <optional>

#include "server/application/datasets/amended_dataset.h"
#include "server/application/serving/memory.h"
#include "server/core/try.h"
#include "server/effects/time_constant.h"

namespace driftwise::application {
namespace {

// Zeros of the run's datums, in the order in which its rows meet them. Nothing: not known.
Result<std::vector<std::optional<DatumRecord>>> zeros_of(Store& store, RunId run,
                                                         const Dataset& data) {
  DRIFTWISE_TRY(auto records, store.points().data(run));
  std::vector<std::int64_t> order;
  if (data.datum.empty()) {
    DRIFTWISE_TRY(const auto first, points_in_dataset(store, run, 1));
    if (!first.empty()) order.push_back(first.front().datum.value);
  }
  for (const std::int64_t id : data.datum)
    if (std::ranges::find(order, id) == order.end()) order.push_back(id);
  std::vector<std::optional<DatumRecord>> zeros;
  for (const std::int64_t id : order) {
    zeros.emplace_back();
    for (auto& record : records)
      if (record.id.value == id) zeros.back() = std::move(record);
  }
  return zeros;
}

// Past of effects with memory: the instants of the zeros and the readings before the first row.
Result<void> add_past(Store& store, const diagnosis::ModelMemory& memory,
                      const std::vector<std::optional<DatumRecord>>& zeros,
                      diagnosis::RunToCheck& run) {
  constexpr int kMostMeans = 2000;  // 200 of the longest time constant
  if (memory.longest_tau_s == 0 || run.data.time_s.empty()) return {};
  DRIFTWISE_TRY(const auto first, points_in_dataset(store, run.run, 1));
  if (first.empty()) return {};
  const CellTime begin = first.front().measured.utc;
  const auto time_s = [&](CellTime at) {
    return run.data.time_s.front() + seconds_from(at - begin);
  };
  CellTime earliest = begin;
  for (const auto& zero : zeros) {
    run.zero_times_s.push_back(zero ? time_s(zero->opened.utc) : kMissing);
    if (zero) earliest = std::min(earliest, zero->opened.utc);
  }
  std::vector<std::string> channels;
  for (const auto& symbol : memory.symbols)
    if (const auto* column = run.data.find(symbol)) channels.push_back(column->channel.name());
  const Nanoseconds reach = nanoseconds_from_s(effects::kForgottenTaus * memory.longest_tau_s);
  DRIFTWISE_TRY(const auto means,
                means_for_memory(store, channels, earliest - reach, begin, kMostMeans));
  for (const auto& reading : means)
    run.before.push_back({time_s(reading.middle()), reading.values});
  return {};
}

}  // namespace

Result<diagnosis::RunToCheck> run_to_check(Store& store, const RunRecord& run,
                                           const diagnosis::ModelMemory& memory,
                                           std::optional<CorrectionId> leaving_out) {
  DRIFTWISE_TRY(auto data, dataset_without(store, std::vector{run.id}, leaving_out));
  diagnosis::RunToCheck to_check{run.id, std::move(data), {}};
  if (run.reason == "imported") return to_check;
  DRIFTWISE_TRY(const auto zeros, zeros_of(store, run.id, to_check.data));
  for (const auto& zero : zeros)
    to_check.zeros.push_back(zero ? zero->values : std::vector<ChannelValue>());
  DRIFTWISE_RETURN_IF_ERROR(add_past(store, memory, zeros, to_check));
  return to_check;
}

}  // namespace driftwise::application
