// Any bytes: an error, or a model that writes and reads back to the same text. What reads may also
// be exported and served: neither may crash on any model.

#include <cstdint>
#include <cstdlib>

#include "server/compensation/snapshot_builder.h"
#include "server/compensation/target.h"
#include "server/formats/export/model_c.h"
#include "server/formats/model/model_json.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const auto model = formats::read_model_json({reinterpret_cast<const char*>(data), size});
  if (!model) return 0;
  const std::string written = formats::write_model_json(*model);
  const auto again = formats::read_model_json(written);
  if (!again || formats::write_model_json(*again) != written) std::abort();
  (void)formats::write_model_c(*model, "fuzz");
  auto builder = compensation::SnapshotBuilder::create(*model, ModelId{1}, {});
  if (!builder) return 0;
  compensation::TargetRequest request;
  request.given = ~0u;
  (void)compensation::compute_target(builder->build({}), request);
  return 0;
}
