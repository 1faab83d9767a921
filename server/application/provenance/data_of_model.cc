#include "server/application/provenance/data_of_model.h"

#include <algorithm>

#include "server/core/try.h"

namespace driftwise::application {
namespace {

std::optional<double> span_s(const std::vector<double>& time_s) {
  if (time_s.empty()) return std::nullopt;
  const auto [first, last] = std::ranges::minmax(time_s);
  return last - first;
}

}  // namespace

Result<std::vector<DataOfModel>> data_of_model(Store& store, const std::vector<RunId>& runs,
                                               CellTime fitted) {
  std::vector<DataOfModel> all;
  for (const RunId id : runs) {
    DRIFTWISE_TRY(const auto run, store.runs().run(id));
    DataOfModel data{id, run.name, !is_of_file(run), std::nullopt, std::nullopt};
    if (run.reason == "imported") {
      DRIFTWISE_TRY(data.rows, store.runs().dataset({&id, 1}));
      data.duration_s = span_s(data.rows->time_s);
    } else if (run.started.utc_ns != 0) {
      data.duration_s = seconds_from((run.ended.utc_ns != 0 ? run.ended : fitted) - run.started);
    }
    all.push_back(std::move(data));
  }
  return all;
}

}  // namespace driftwise::application
