#pragma once
// Steps of a plan that wait for one another: each changes what the next one reads, round in a
// circle. Such steps are gone through several times, and a plan is refused whose passes would not
// settle. Pure; any thread.

#include <array>
#include <cstdint>

#include "server/plans/joint_snapshot.h"

namespace driftwise::plans {

// Passes through the steps of a plan that has a circle. With at most kMostContraction per pass what
// is left after them is below 1e-6 of what the first one added.
constexpr std::size_t kPassesOfCircle = 3;
constexpr double kMostContraction = 0.01;

struct StepCircles {
  // Bit b of after[a]: step a changes a coordinate that step b reads.
  std::array<std::uint32_t, kMostSteps> after{};
  // Bit b of circle[a]: both are in one circle. 0: a is in none.
  std::array<std::uint32_t, kMostSteps> circle{};

  bool feeds(std::size_t a, std::size_t b) const { return (after[a] >> b & 1) != 0; }
  bool together(std::size_t a, std::size_t b) const { return (circle[a] >> b & 1) != 0; }
  bool any() const;
};
StepCircles circles_of(const JointSnapshot& snapshot);

// Largest factor by which one pass changes what is still wrong with the added terms: the growth of
// the passes with every slope at its largest size within the domain of its model, looked at on a
// grid of five places along each coordinate. Below 1 the passes settle, whatever the target.
double contraction_of(const JointSnapshot& snapshot);

}  // namespace driftwise::plans
