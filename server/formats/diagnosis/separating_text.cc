#include "server/formats/diagnosis/separating_text.h"

#include "server/formats/csv/trajectory_csv.h"

namespace driftwise::formats {

diagnosis::SeparatingExperiment separating_text(const diagnosis::SeparatingPlan& plan) {
  return {.why = plan.why,
          .predicted_power = plan.predicted_power,
          .trajectory_csv = plan.trajectory ? write_trajectory_csv(*plan.trajectory) : "",
          .estimated_s = plan.estimated_s};
}

}  // namespace driftwise::formats
