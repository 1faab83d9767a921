#pragma once
// Turns a model and the observed stream of readings into snapshots.
//
// Feed it every reading from the moment the daemon has them (after a restart: the stored ones
// first). Only this observed stream advances effects with memory; asking for a snapshot or a target
// never does. One thread.

#include <span>
#include <vector>

#include "server/calibration/model.h"
#include "server/compensation/snapshot.h"
#include "server/core/cell_description.h"
#include "server/core/reading.h"
#include "server/core/result.h"

namespace driftwise::compensation {

class SnapshotBuilder {
 public:
  // The cell gives the serving rules, the thermometers' uncertainties (u_k) and the scales'
  // (u_scale_nm). Errors, failed_precondition: NOT_A_MOTOR_MODEL (an output that is no motor
  // coordinate in a length unit), TERM_NOT_SERVABLE (an effect that this build cannot follow, or
  // one that reads the wanted pose), MODEL_TOO_LARGE (kMaxBasis, kMaxInputs, kMaxOutputs).
  static Result<SnapshotBuilder> create(calibration::Model model, ModelId id,
                                        const CellDescription& cell);

  // In time order. Channels that the model does not use are passed over; kMissing values change
  // nothing, so that the last good one grows old.
  void observe(const Reading& reading);
  void observe(std::span<const ChannelValue> values, CellTime at);

  // The zero of the present datum: motor coordinates read back (and force, where it is measured) at
  // pose 0, with every temperature at that instant. From here on q = q_zero + f(pose, now) - f(0,
  // then), coefficients' covariance included, so that the constant of the model's own datum drops
  // out. Without it targets stay in the model's datum. Errors: failed_precondition,
  // INCOMPLETE_DATUM, naming the channel that is not among the values.
  Result<void> anchor(std::span<const ChannelValue> values);
  // The present datum is the model's own: nothing to shift.
  void keep_model_datum();

  // What every target until the next rebuild is computed from. Pure: now only decides about ages.
  Snapshot build(CellTime now) const;

  const calibration::Model& model() const { return model_; }

 private:
  SnapshotBuilder() = default;
  calibration::Model model_;
};

}  // namespace driftwise::compensation
