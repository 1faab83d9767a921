#pragma once
// Changes of thermometers from row to row, beyond their trend and beyond what the other
// thermometers foretell. Readings in K, rows of the dataset.

#include <algorithm>
#include <cstddef>
#include <vector>

#include "server/core/data/dataset.h"

namespace driftwise::diagnosis {

inline constexpr double kFarOffSensor = 12;  // usual changes: a jump that the readings alone show
inline constexpr double kSmallest_k = 0.02;  // no smaller one is shown by the readings alone
inline constexpr double kMoves = 4;          // usual changes: a thermometer that follows an event
inline constexpr std::size_t kWindow = 6;    // rows of a level

// A structure thermometer of the dataset.
struct Sensor {
  DatasetColumn* column = nullptr;
  double usual = 0;  // size of own_change() from row to row
  // Rows, ascending. jumps: so large that the readings alone show one. suspects: all others that
  // stand out, named on the outputs' evidence only.
  std::vector<std::size_t> jumps, suspects;
  std::vector<double> changes{};  // own_change() of every row; empty: worked out when asked for
  bool jumps_at(std::size_t row) const { return std::ranges::find(jumps, row) != jumps.end(); }
};

// Readings without what the changes of the other thermometers predict: a room that warms, or in
// which a door is opened, does so at several of them. As read where there are no others or too few
// rows.
std::vector<double> beyond_the_others(const std::vector<Sensor>& sensors, std::size_t sensor);

// Smallest step between neighbouring values, K: that of a thermometer that reads in 0.01 K.
double resolution_of(const std::vector<double>& v);

// Change from the row before, K, beyond the usual change of the rows about it: a room that warms
// takes all rows along.
double own_change(const std::vector<double>& v, std::size_t row);

// Of every row; 0 of the first.
std::vector<double> own_changes(const std::vector<double>& v);

// The rows, ascending, with the largest changes: as many as are worth a look at the outputs.
std::vector<std::size_t> largest_changes(std::vector<std::size_t> rows,
                                         const std::vector<double>& beyond);

// Level after a row less what the level before it and the trend predict, K: medians of kWindow
// rows.
double level_change(const std::vector<double>& v, std::size_t row);

// True: the level a little later differs by a quarter of the change or more. A part that warms goes
// on warming, or cools again.
bool goes_on_as_ramp(const std::vector<double>& v, std::size_t row, double size);

// One per row: does more than twice the usual step of time lie before it? What changed meanwhile
// changed at no instant. Untimed rows have no pause.
std::vector<char> after_a_pause(const Dataset& dataset);

// True: there are others, and none changes at this row beyond its noise.
bool stands_alone(const std::vector<Sensor>& sensors, std::size_t sensor, std::size_t row);

// Standard deviation of own_change() over the rows, tails left out, K.
double usual_change(const std::vector<double>& v);

// Chance of a change as large as that at this row, there, by Student's law of the other changes.
double chance_at_row(const std::vector<double>& v, std::size_t row, double resolution);

// Standard deviation of own_change() of `beyond`, one per row, at rows where the others move about
// as much as at this one, where that is clearly more than over all rows, which it is else, K. What
// the others foretell is worse where a room moves at once: thermometers follow it with different
// delays. sensors: with their usual changes.
std::vector<double> usual_beside_others(const std::vector<Sensor>& sensors, std::size_t sensor,
                                        const std::vector<double>& beyond);

// Sets jumps and suspects. beyond: of beyond_the_others(); usual_beside: of usual_beside_others().
void find_jumps(Sensor& sensor, const std::vector<double>& beyond,
                const std::vector<double>& usual_beside, const Dataset& dataset);

}  // namespace driftwise::diagnosis
