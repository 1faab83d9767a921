#include "server/plans/band_poses.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "server/plans/band_ranges.h"

namespace driftwise::plans {
namespace {

using compensation::Variable;

// Of the grid between from and to, and between to and fade_to.
constexpr int kAngleSteps = 16, kLengthSteps = 6;
// Turns of the positions that are always looked at; the rest come later, the coarse ones first.
constexpr int kAlways = 0, kBorder = 1, kInBetween = 2;

// Turn of every step between two ends: the middle kAlways, the quarters kInBetween, the eighths one
// later.
std::vector<int> turns_of_steps(int steps) {
  std::vector<int> turn(static_cast<std::size_t>(steps) + 1, kBorder);
  struct Part {
    int low, high, turn;
  };
  for (std::deque<Part> parts = {{0, steps, kAlways}}; !parts.empty(); parts.pop_front()) {
    const auto [low, high, now] = parts.front();
    const int middle = (low + high) / 2;
    if (middle == low) continue;
    turn[static_cast<std::size_t>(middle)] = now;
    const int after = std::max(now + 1, kInBetween);
    parts.push_back({low, middle, after});
    parts.push_back({middle, high, after});
  }
  return turn;
}

}  // namespace

BandPoses::BandPoses(const JointSnapshot::Robot& robot, std::vector<Variable> inputs,
                     std::int64_t most_poses)
    : robot_(robot), inputs_(std::move(inputs)), most_poses_(most_poses) {
  std::int64_t whole = 1;
  for (const auto variable : inputs_) {
    lines_.push_back(line_of(variable));
    whole *= static_cast<std::int64_t>(lines_.back().at.size());
  }
  is_whole_ = whole <= most_poses_;
  choose_turns();
}

std::size_t BandPoses::Line::size_until(int turn_reached) const {
  return static_cast<std::size_t>(
      std::ranges::count_if(turn, [turn_reached](int one) { return one <= turn_reached; }));
}

BandPoses::Line BandPoses::line_of(Variable variable) const {
  Line line;
  const auto put = [&line](double value, int turn) {
    line.at.push_back(value);
    line.turn.push_back(turn);
    line.last_turn = std::max(line.last_turn, turn);
  };
  for (std::size_t p = 0; p < robot_.band.parts; ++p) {
    const auto& part = robot_.band.part[p];
    if (part.coordinate != variable) continue;
    put(part.centre, kAlways);
    const auto add = [&](double distance, int turn) {
      if (part.side != BandSide::below) put(part.centre + distance, turn);
      if (part.side != BandSide::above) put(part.centre - distance, turn);
    };
    // Inside, where another coordinate may be in its own band.
    const Range inside = range_of(robot_.fine, variable);
    if (part.side == BandSide::above) put(inside.min, kAlways);
    if (part.side == BandSide::below) put(inside.max, kAlways);
    const int steps = is_rotation(variable) ? kAngleSteps : kLengthSteps;
    const auto turn = turns_of_steps(steps);
    const int last = robot_.band.anchored ? steps : steps - 1;  // else the coarse model alone
    for (int k = 0; k <= last; ++k)
      add(part.from + (part.to - part.from) * k / steps, turn[static_cast<std::size_t>(k)]);
    if (robot_.band.anchored)
      for (int k = 1; k < steps; ++k)
        add(part.to + (part.fade_to - part.to) * k / steps, turn[static_cast<std::size_t>(k)]);
    return line;
  }
  const Range fine = range_of(robot_.fine, variable), coarse = range_of(*robot_.coarse, variable);
  const bool in_fine = fine.min < fine.max, in_coarse = coarse.min < coarse.max;
  const Range both = in_fine && in_coarse
                         ? Range{std::max(fine.min, coarse.min), std::min(fine.max, coarse.max)}
                     : in_fine ? fine
                               : coarse;
  const bool has_one = variable == Variable::force || !(both.min < both.max);
  if (!has_one) put(both.min, kAlways);
  put(0.5 * (both.min + both.max), kAlways);
  if (!has_one) put(both.max, kAlways);
  return line;
}

void BandPoses::choose_turns() {
  for (const auto& line : lines_) turns_.push_back(is_whole_ ? line.last_turn : kAlways);
  if (is_whole_) return;
  const auto coarse_poses = [this] {
    double count = 1;
    for (std::size_t j = 0; j < lines_.size(); ++j)
      count *= static_cast<double>(lines_[j].size_until(turns_[j]));
    return count;
  };
  for (bool grew = true; std::exchange(grew, false);)
    for (std::size_t j = 0; j < lines_.size(); ++j) {
      if (turns_[j] == lines_[j].last_turn) continue;
      ++turns_[j];
      if (coarse_poses() <= 0.5 * static_cast<double>(most_poses_))
        grew = true;
      else
        --turns_[j];
    }
}

Values BandPoses::pose_at(const Place& place) const {
  Values pose{};
  for (std::size_t j = 0; j < inputs_.size(); ++j)
    pose[static_cast<std::size_t>(inputs_[j])] = lines_[j].at[place[j]];
  return pose;
}

bool BandPoses::two_models_at(const Values& pose) const {
  const double w = fine_weight(robot_.band, pose), fade = anchor_fade(robot_.band, pose);
  return (w > 0 && w < 1) || (w == 0 && fade > 0 && fade < 1);
}

bool BandPoses::is_chosen(std::size_t input, std::size_t position) const {
  return lines_[input].turn[position] <= turns_[input];
}

// The next place of the coarse grid; false: that was the last one.
bool BandPoses::next(Place& place) const {
  for (std::size_t j = 0; j < place.size(); ++j) {
    const std::size_t size = lines_[j].at.size();
    do ++place[j];
    while (place[j] < size && !is_chosen(j, place[j]));
    if (place[j] < size) return true;
    place[j] = 0;  // a centre or an end: always chosen
  }
  return false;
}

void BandPoses::visit(const std::function<bool(const Values&, const Place&)>& visit) {
  Place place(inputs_.size(), 0);
  visited_ = 0;
  do {
    const Values pose = pose_at(place);
    if (!two_models_at(pose)) continue;
    ++visited_;
    if (!visit(pose, place)) return;
  } while (next(place));
}

void BandPoses::climb(Place from, const Worth& worth) {
  double best = -HUGE_VAL;
  const auto better_at = [&](const Place& place) {
    const Values pose = pose_at(place);
    if (climbed_ >= most_poses_ / 2 || !two_models_at(pose)) return false;
    ++climbed_;
    const double here = worth(pose);
    if (!(here > best)) return false;
    best = here;
    return true;
  };
  better_at(from);
  for (bool climbed = true; std::exchange(climbed, false);)
    for (std::size_t j = 0; j < from.size(); ++j)
      for (std::size_t k = 0; k < lines_[j].at.size(); ++k) {
        const std::size_t before = std::exchange(from[j], k);
        if (k == before) continue;
        if (better_at(from))
          climbed = true;
        else
          from[j] = before;
      }
}

std::size_t BandPoses::region_of(const Values& pose) const {
  std::size_t region = 0;
  for (std::size_t p = 0; p < robot_.band.parts; ++p) {
    const auto& part = robot_.band.part[p];
    const double d = distance_of(part, pose[static_cast<std::size_t>(part.coordinate)]);
    region = 3 * region + (d <= part.from ? 0u : d < part.to ? 1u : 2u);
  }
  return region;
}

void WorstPlaces::add(std::size_t region, double worth, const BandPoses::Place& place) {
  const auto [at, is_new] = by_region_.try_emplace(region, Best{worth, place});
  if (!is_new && worth > at->second.worth) at->second = {worth, place};
}

std::vector<BandPoses::Place> WorstPlaces::first(std::size_t count) const {
  std::vector<const Best*> all;
  for (const auto& [region, best] : by_region_) all.push_back(&best);
  std::ranges::stable_sort(all, [](auto* a, auto* b) { return a->worth > b->worth; });
  std::vector<BandPoses::Place> places;
  for (std::size_t i = 0; i < std::min(count, all.size()); ++i) places.push_back(all[i]->place);
  return places;
}

}  // namespace driftwise::plans
