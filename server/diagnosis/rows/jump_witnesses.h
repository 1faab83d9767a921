#pragma once
// Judgement of one row at which a thermometer changes: a jump of the sensor, an exchange of two, or
// a part that really warmed. Witnesses: the readings, their course afterwards and the outputs.
// Readings in K, likelihoods in 2 ln L, rows of the dataset.

#include <optional>
#include <vector>

#include "server/diagnosis/rows/screen.h"
#include "server/diagnosis/rows/sensor_changes.h"

namespace driftwise::diagnosis {

class JumpWitnesses {
 public:
  // All outlive it. beyond: of each sensor, beyond_the_others(). outputs: their number.
  JumpWitnesses(Dataset& dataset, std::vector<Sensor>& sensors,
                const std::vector<std::vector<double>>& beyond, std::size_t outputs, double alpha,
                const OutputsLikelihood& two_ln_likelihood)
      : dataset_(dataset),
        sensors_(sensors),
        beyond_(beyond),
        outputs_(outputs),
        alpha_(alpha),
        two_ln_likelihood_(two_ln_likelihood) {}

  // The fault at this row, if there is one. Readings are mended where the outputs speak for it.
  // Its p is of one sensor.
  std::optional<FaultySensor> look_at(std::size_t sensor, std::size_t row);

 private:
  std::vector<double>& values_of(std::size_t sensor) { return sensors_[sensor].column->values; }
  std::vector<std::size_t> rows_from(std::size_t row) const;
  bool takes_the_place_of(std::size_t sensor, std::size_t other, std::size_t row);
  // as_read: 2 ln L with the readings as they are.
  std::optional<FaultySensor> exchange(std::size_t sensor, std::size_t other, std::size_t row,
                                       double as_read);
  std::optional<FaultySensor> jump(std::size_t sensor, std::size_t row, double as_read);

  Dataset& dataset_;
  std::vector<Sensor>& sensors_;
  const std::vector<std::vector<double>>& beyond_;
  std::size_t outputs_;
  double alpha_;
  const OutputsLikelihood& two_ln_likelihood_;
  std::optional<double> as_read_;  // 2 ln L; none: readings were mended since
};

}  // namespace driftwise::diagnosis
