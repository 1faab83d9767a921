#pragma once
// The linear axis after its campaign: zeros taken while the room is beyond what the model was
// fitted on, and targets asked for when it is back within, judged by the plant's truth.

#include <cstdint>
#include <string>
#include <vector>

#include "server/calibration/model/fit_options.h"
#include "tests/statistics/coverage_count.h"

namespace driftwise::statistics {

struct LaterTarget {
  double zero_excess = 0;         // of the zero's conditions, half widths of the fitted ranges
  double error_nm = 0, u_nm = 0;  // as served
  double u_of_pose_nm = 0;        // the same, judged at the pose and the present conditions only
  bool is_flagged = false;        // ZERO_OUTSIDE_DOMAIN
};

struct LaterRoom {
  bool stays_within = false;  // while the zeros are taken: on the campaign's way instead of beyond
  calibration::Select select = calibration::Select::stepwise;  // of the model's terms
};

// Of one machine; only targets whose pose and conditions lie within the domain. Each zero is one
// draw: its targets share the error at the zero.
std::vector<std::vector<LaterTarget>> later_zeros(std::uint64_t seed, const LaterRoom& room = {});

// Counted by how far outside the zero was.
class LaterZeroCount {
 public:
  struct Class {
    double from = 0, to = 0;  // of zero_excess; from is inside the class, to is not
    int zeros = 0, targets = 0, hits = 0, hits_of_pose = 0, flagged = 0;
    double error_nm2 = 0, ratio2 = 0, ratio2_of_pose = 0;  // sums of squares
    CoverageCount by_machine;
    std::vector<double> u_nm;
    double rate() const { return targets == 0 ? 0 : static_cast<double>(hits) / targets; }
    double rate_of_pose() const {
      return targets == 0 ? 0 : static_cast<double>(hits_of_pose) / targets;
    }
  };
  // Of one machine, whose zeros share its errors.
  void add(const std::vector<std::vector<LaterTarget>>& zeros);
  // Inside; to a tenth, a quarter, a half, one half width outside; further.
  const std::vector<Class>& classes() const { return classes_; }
  std::string table() const;

 private:
  static std::vector<Class> empty_classes();
  std::vector<Class> classes_ = empty_classes();
};

}  // namespace driftwise::statistics
