#pragma once
// The weight between two models of one robot, and the shift that anchors the coarse one.
//
// Step: S(t) = 10 t^3 - 15 t^4 + 6 t^5 for t in 0..1, 0 below and 1 above. Its first and second
// derivatives vanish at both ends, so that rates and accelerations of motor coordinates are
// continuous. Largest slope: 15/8, at the middle.
//
// Distance d of a coordinate c from the band's centre c0: |c - c0|; of a band on one side c - c0
// above and c0 - c below, 0 on the other side.
//
// Weight of the fine model: the product over the band's coordinates of S((to - d) / (to - from)).
// It is 1 where every d is at most from, and 0 where one of them is to or more. (The study says "a
// weight", of max(|rx|, |ry|); the maximum has a kink where |rx| = |ry|, the product has none.)
//
// Anchor: the coarse model q_c becomes q_c + fade(p) * (q_f - q_c)(held(p)), held(p) the pose with
// each band coordinate saturated smoothly at from + (to - from) / 2, fade the product of
// S((fade_to - d) / (fade_to - to)). The two models then agree at the band, and the shift ends
// where no fine model is known any more.

#include <array>
#include <cstddef>

#include "server/compensation/snapshot.h"
#include "server/plans/serving_plan.h"

namespace driftwise::plans {

constexpr double kSteepestStep = 15.0 / 8.0;

double smooth_step(double t) noexcept;

// One coordinate of a band, ready to be worked with.
struct BandPart {
  compensation::Variable coordinate = compensation::Variable::rx;
  double from = 0, to = 0, fade_to = 0;  // request's unit; fade_to = to: no anchor
  double centre = 0;
  BandSide side = BandSide::both;
};

// Of a value of the part's coordinate from its centre; at least 0.
double distance_of(const BandPart& part, double value) noexcept;
// How far from the centre a range min to max reaches on every side that counts; below 0: it ends
// before the centre.
double reach_of(const BandPart& part, double min, double max) noexcept;

struct Band {
  std::size_t parts = 0;
  std::array<BandPart, 6> part{};
  bool anchored = false;
};

using Values = std::array<double, compensation::kVariables>;

double fine_weight(const Band& band, const Values& pose) noexcept;
double anchor_fade(const Band& band, const Values& pose) noexcept;
// The pose at which the difference of the models is taken.
Values held_at_border(const Band& band, Values pose) noexcept;

}  // namespace driftwise::plans
