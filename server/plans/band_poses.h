#pragma once
// Poses at which the check of a band looks: a grid over the band and, where an anchor fades out,
// beyond it, at the ends and the middle of every other input's fitted range.
//
// The whole grid grows with the power of the band's coordinates (33 positions of each angle, 13 of
// each length), so only as much of it is visited as a fixed number of poses allows. What is always
// in: every combination of the middle of the band (and of the fade) on each side that counts, of
// the centre, and of the ends and the middle of every other input. The positions between are added
// coarse ones first, one coordinate after the other, until half of the number is used; the other
// half climbs on the whole grid from the worst poses found (climb()). A grid that fits is visited
// whole.

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "server/plans/joint_snapshot.h"

namespace driftwise::plans {

class BandPoses {
 public:
  using Place = std::vector<std::size_t>;  // position of every input
  using Worth = std::function<double(const Values& pose)>;

  // robot: with a coarse model; it outlives this.
  BandPoses(const JointSnapshot::Robot& robot, std::vector<compensation::Variable> inputs,
            std::int64_t most_poses);

  bool is_whole() const { return is_whole_; }
  // Poses where two models have a say: of the last visit, and of every climb.
  std::int64_t seen() const { return visited_ + climbed_; }

  // Poses where two models have a say, until visit answers false.
  void visit(const std::function<bool(const Values& pose, const Place& place)>& visit);

  // Climbs on the whole grid, one input at a time, until no position of any is better or half of
  // most_poses is used. worth is asked only where two models have a say.
  void climb(Place from, const Worth& worth);

  // Which of the band's coordinates is inside, in the band and beyond it: worst poses of different
  // regions lead to different summits.
  std::size_t region_of(const Values& pose) const;

 private:
  struct Line {  // positions of one input, and in which turn each comes into the coarse grid
    std::vector<double> at;
    std::vector<int> turn;
    int last_turn = 0;
    std::size_t size_until(int turn_reached) const;
  };
  Line line_of(compensation::Variable variable) const;
  void choose_turns();
  Values pose_at(const Place& place) const;
  bool two_models_at(const Values& pose) const;
  bool next(Place& place) const;
  bool is_chosen(std::size_t input, std::size_t position) const;

  const JointSnapshot::Robot& robot_;
  std::vector<compensation::Variable> inputs_;
  std::vector<Line> lines_;
  std::vector<int> turns_;  // reached, by input
  std::int64_t most_poses_, visited_ = 0, climbed_ = 0;
  bool is_whole_ = true;
};

// Worst places by region, of one figure.
class WorstPlaces {
 public:
  void add(std::size_t region, double worth, const BandPoses::Place& place);
  // The most worth first.
  std::vector<BandPoses::Place> first(std::size_t count) const;

 private:
  struct Best {
    double worth;
    BandPoses::Place place;
  };
  std::map<std::size_t, Best> by_region_;
};

}  // namespace driftwise::plans
