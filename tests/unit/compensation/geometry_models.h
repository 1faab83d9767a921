#pragma once
// Models with a robot's geometry that no data judged, served.

#include <stdexcept>
#include <utility>

#include "server/compensation/snapshot_builder.h"
#include "server/compensation/target.h"

namespace driftwise::compensation {

inline constexpr CellTime kBuilt{1'000'000'000'000};

inline calibration::Model imported(const KinematicsDescription& robot) {
  calibration::Model model;
  model.geometry = calibration::Geometry{robot, {}, {}};
  return model;
}

inline SnapshotBuilder serving(const calibration::Model& model) {
  auto builder = SnapshotBuilder::create(model, ModelId{1}, CellDescription{});
  if (!builder) throw std::runtime_error(builder.error().message);
  return std::move(*builder);
}

inline Error refusal_of(const Snapshot& snapshot, const TargetRequest& request) {
  return refusal_error(snapshot, compute_target(snapshot, request));
}

}  // namespace driftwise::compensation
