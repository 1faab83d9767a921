#include "server/application/runs/reference_record.h"

#include <chrono>

namespace driftwise::application {
namespace {

constexpr const char* kReferenced = "referenced_1";

}  // namespace

Awaitable<void> keep_reference(StoreWriter& writer, CellTime at, std::int64_t sequence,
                               bool referenced) {
  writer.add(Reading{kReferenceDevice, at, at, sequence, {{kReferenced, referenced ? 1.0 : 0.0}}});
  auto writing = writer.flush();
  static_cast<void>(co_await std::move(writing));
}

Awaitable<std::optional<bool>> kept_reference(StoreWriter& writer, CellTime first, CellTime last) {
  constexpr int kNewest = 1;
  auto asking = writer.readings().readings(kReferenceDevice, first,
                                           last + std::chrono::nanoseconds(1), kNewest);
  const auto found = co_await std::move(asking);
  if (!found || found->empty()) co_return std::nullopt;
  const double* value = found->back().find(kReferenced);
  co_return value ? std::optional(*value != 0) : std::nullopt;
}

}  // namespace driftwise::application
