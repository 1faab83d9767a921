#pragma once
// Identifiers are types: a run's number cannot be passed where a model's is asked for.

#include <compare>
#include <cstdint>

namespace driftwise {

struct RunId {
  std::int64_t value = 0;
  auto operator<=>(const RunId&) const = default;
};
struct DatumId {
  std::int64_t value = 0;
  auto operator<=>(const DatumId&) const = default;
};
struct PointId {
  std::int64_t value = 0;
  auto operator<=>(const PointId&) const = default;
};
struct AttemptId {
  std::int64_t value = 0;
  auto operator<=>(const AttemptId&) const = default;
};
struct ModelId {
  std::int64_t value = 0;
  auto operator<=>(const ModelId&) const = default;
};
struct EventId {
  std::int64_t value = 0;
  auto operator<=>(const EventId&) const = default;
};
struct DiagnosisId {
  std::int64_t value = 0;
  auto operator<=>(const DiagnosisId&) const = default;
};
struct CorrectionId {
  std::int64_t value = 0;
  auto operator<=>(const CorrectionId&) const = default;
};
struct ImprovementId {
  std::int64_t value = 0;
  auto operator<=>(const ImprovementId&) const = default;
};
struct PlanId {
  std::int64_t value = 0;
  auto operator<=>(const PlanId&) const = default;
};
struct QueueEntryId {
  std::int64_t value = 0;
  auto operator<=>(const QueueEntryId&) const = default;
};

}  // namespace driftwise
