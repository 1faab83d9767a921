#pragma once
// Origin of a model, as far as serving it is concerned.

#include <optional>
#include <string>
#include <vector>

#include "server/application/plumbing/store_reader.h"
#include "server/calibration/model/model.h"

namespace driftwise::application {

struct ModelOrigin {
  // The first, in time, of the runs it was fitted from: its constant belongs there.
  std::optional<DatumId> own_datum;
  std::vector<std::string> symbols;  // that its outputs and terms read
  // All of its runs were measured under the present cell file, to their end.
  bool under_present = false;
};

// present: hash of the present cell file.
Awaitable<ModelOrigin> origin_of(const calibration::Model& model, StoreReader& reader,
                                 std::string present);

}  // namespace driftwise::application
