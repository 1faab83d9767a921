#pragma once
// A serving plan as it is written: which model answers for which robot, which two models of one
// robot are blended, which predicted motion of one robot is added to the wanted pose of another.
// Text form: docs/plans.md; parsed in server/formats/plan.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/compensation/snapshot.h"
#include "server/core/ids.h"

namespace driftwise::plans {

constexpr std::size_t kMostRobots = 4, kMostSteps = 8, kMostBand = 6;

// Where a band counts the distance from its centre. On the other side of the centre the fine model
// answers alone.
enum class BandSide : std::uint8_t { both, above, below };

// One coordinate of a band, in the request's unit, by the distance from its centre: all of the fine
// model up to from, nothing of it beyond to. With anchoring the coarse model's shift fades out
// between to and fade_to.
struct BandEdge {
  compensation::Variable coordinate = compensation::Variable::rx;
  double from = 0, to = 0;
  std::optional<double> fade_to;
  double centre = 0;
  BandSide side = BandSide::both;
};

struct Blend {
  ModelId coarse;
  std::vector<BandEdge> band;
  bool anchored = false;  // the coarse model is shifted to the fine one at the band
};

struct PlannedRobot {
  std::string id;  // "ma"; empty: the plan's only robot, its models' names carry no id
  ModelId model;   // the one that answers; of a blend: the fine one
  std::optional<Blend> blend;
  std::string tool;  // that it carries; empty: not said
};

// One step: the motion that a model of robot `from` predicts is added to the wanted pose of `to`.
struct ParasiticStep {
  ModelId model;
  std::string from, to;
  std::vector<compensation::Variable> add;  // its other outputs are reported, not corrected
};

struct ServingPlan {
  std::string name;
  std::vector<PlannedRobot> robots;
  std::vector<ParasiticStep> steps;  // in this order
  // Where several robots have z: who takes a z that is asked for without a robot's id, and where
  // the others stand unless the request says so.
  std::optional<std::string> z_taken_by;
  double z_rest_mm = 0;

  const PlannedRobot* find(const std::string& robot) const;
  std::vector<ModelId> models() const;  // each once, ascending
};

// "ma.rx_arcsec"; of a robot without an id "rx_arcsec".
std::string channel_name(const std::string& robot, const std::string& channel);
std::string channel_name(const std::string& robot, compensation::Variable coordinate);

// What happens to a wanted pose, in order, a sentence each.
std::vector<std::string> steps_of(const ServingPlan& plan);

}  // namespace driftwise::plans
