#pragma once
// Do two models of one robot agree well enough over the band of their blend?
//
// Rates: along any straight path within the band's coordinates the rate of every motor coordinate
// differs from the fine model's (beyond the band, where an anchor fades out: from the coarse one's)
// by less than half of the largest rate of the fine model in that direction. Lengths and angles
// have no common unit, so a direction is taken among the angles, or along one length. Jacobian: its
// determinant keeps its sign and at least half its size, where the robot has as many motor
// coordinates as inputs. Both are looked at on a grid over the band, at the ends and the middle of
// every other input's fitted range, under the snapshot's conditions. The share of a rate has 5 % on
// top for what lies between the grid's points.
//
// A grid of more than most_poses (three angles and more) is not visited whole: a coarser one is,
// and the figures climb on the whole grid from the worst places of each region (band_poses.h). The
// time is then that of most_poses, whatever the number of coordinates. A summit that no climb
// reaches is missed; the report says that a part was looked at.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/data/reading.h"
#include "server/plans/joint_snapshot.h"

namespace driftwise::plans {

constexpr double kMostRateShare = 0.5, kLeastDeterminantShare = 0.5;
// How far beyond its fitted range the fine model may be asked within a band: the study blends from
// 300 to 350 arcsec a model fitted to 300.
constexpr double kMostExtrapolation = 1.25;
// Of one look; a refused band is looked at up to 20 times, until the first pose that refuses.
constexpr std::int64_t kMostPoses = 100'000;

struct BandReport {
  std::string robot;
  double largest_difference_nm = 0;      // of a motor coordinate, between the two models as fitted
  std::string largest_channel;           // "ma.q2_mm"
  std::vector<ChannelValue> largest_at;  // names with the robot's id
  double difference_arcsec = 0;          // the same, as a rotation; 0: no rotation or not square
  double rate_share = 0;                 // largest deviation, in largest rates of the fine model
  std::optional<double> determinant_share;  // smallest; none: not square
  bool anchored = false;
  // Of the first entry of the band, in the request's unit; each found by trying. none: not needed,
  // or no width within the models' domains does.
  std::optional<double> wider_to, anchored_fade_to;
  std::int64_t poses = 0;  // looked at
  bool whole_grid = true;  // false: a coarser grid, and climbs from the worst places of it

  bool accepted() const {
    return rate_share < kMostRateShare &&
           (!determinant_share || *determinant_share > kLeastDeterminantShare);
  }
};

// robot: with a coarse model. Looks for what would be accepted where the band as it is is not.
BandReport check_band(const JointSnapshot::Robot& robot, std::int64_t most_poses = kMostPoses);

// "the models differ by 57.6 um of ma.q2_mm (200 arcsec) at ma.rx_arcsec = 340, ...".
std::string sentence_of(const BandReport& report);

}  // namespace driftwise::plans
