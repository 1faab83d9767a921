#include "server/application/provenance/model_origin.h"

#include <algorithm>

#include "server/application/provenance/promotion_questions.h"

namespace driftwise::application {

Awaitable<ModelOrigin> origin_of(const calibration::Model& model, StoreReader& reader,
                                 std::string present) {
  ModelOrigin origin{{}, symbols_used(model), false};
  const auto runs = model.lineage.runs;
  if (runs.empty()) co_return origin;
  const auto data = co_await reader.points().data(runs.front());
  if (data && !data->empty()) origin.own_datum = data->front().id;
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
