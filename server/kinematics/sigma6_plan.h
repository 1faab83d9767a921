#pragma once
// The measuring plan of the Sigma6 (Fazenda, EPFL thesis 3712 (2007), chapter on its verification):
// stages with their set-ups and hours, and the prisms that carry the autocollimators beyond their
// range. What the thesis does not print is marked "assumed".

#include <array>
#include <string>
#include <vector>

#include "server/core/trajectory/trajectory.h"
#include "server/kinematics/six_struts.h"

namespace driftwise::kinematics {

// A mirror prism: each facet is turned from the cube's face by a known angle, so that an
// autocollimator, which sees 400 arcsec to either side, reads about that angle.
struct MirrorPrism {
  std::vector<double> facets_arcsec;  // 0: the cube's own face
  double range_arcsec = 400;          // of the autocollimator
};
struct FacetReading {
  std::size_t facet = 0;
  double reading_arcsec = 0;  // angle = facet + reading
};
// The facet that reads a rotation. Errors: out_of_range NO_POSE: between two facets nothing reads
// it, naming the nearest angle that is read.
Result<FacetReading> facet_for(const MirrorPrism& prism, double angle_arcsec);
// -3, -1.5, 0, 1.5 and 3 degrees.
MirrorPrism sigma6_prism();

struct SigmaStage {
  std::string name;
  int set_ups = 1;         // each with preparation and stabilisation, and the plan once
  double prepare_h = 0.5;  // by a person
  double stabilise_h = 9;  // of the box after it was opened
  double published_h = 0;  // all of it
  Trajectory plan;         // of one set-up, q1_mm to q6_mm
  std::string assumed;     // what of it the thesis does not print; empty: nothing
};

// Errors: those of SixStruts::motors (a robot that does not reach the plan).
Result<std::vector<SigmaStage>> sigma6_stages(const SixStruts& robot);

}  // namespace driftwise::kinematics
