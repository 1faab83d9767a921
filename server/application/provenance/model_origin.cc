#include "server/application/provenance/model_origin.h"

#include <algorithm>

#include "server/application/provenance/promotion_questions.h"

namespace driftwise::application {
namespace {

// The datum that the rows of a fit begin in: they are joined in the order of time, whatever the
// order in which the runs were named.
std::optional<DatumId> first_datum(Store& store, const std::vector<RunId>& runs) {
  std::optional<DatumRecord> first;
  for (const RunId run : runs) {
    auto data = store.points().data(run);
    if (!data || data->empty()) continue;
    if (!first || data->front().opened.utc < first->opened.utc) first = std::move(data->front());
  }
  return first ? std::optional(first->id) : std::nullopt;
}

}  // namespace

Awaitable<ModelOrigin> origin_of(const calibration::Model& model, StoreReader& reader,
                                 std::string present) {
  ModelOrigin origin{{}, symbols_used(model), false};
  const auto runs = model.lineage.runs;
  if (runs.empty()) co_return origin;
  origin.own_datum = co_await reader.call(first_datum, runs);
  origin.under_present = co_await reader.call(
      [](Store& store, const std::vector<RunId>& fitted_from, const std::string& hash) {
        return std::ranges::all_of(fitted_from, [&](RunId run) {
          const auto used = store.configurations().of_run(run);
          return used && !used->empty() && used->back().hash == hash;
        });
      },
      runs, present);
  co_return origin;
}

}  // namespace driftwise::application
