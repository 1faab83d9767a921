// Thermometers in a room whose doors are opened: each follows the air with its own delay, so that
// the others foretell one of them worse in the rows of a door than in quiet ones.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "server/diagnosis/rows/sensor_changes.h"

namespace driftwise::diagnosis {
namespace doors_of_a_room_test {
namespace {

constexpr std::size_t kRows = 600, kBetweenDoors = 15;
constexpr double kDelays_rows[] = {1.0, 3.0, 4.0};  // of three thermometers behind the air

bool is_door(std::size_t row) { return row % kBetweenDoors == 0; }

// Air that a door cools by 0.08 to 0.12 K at once and that comes back within five rows.
Dataset room(unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> door_k(0.08, 0.12);
  Dataset data;
  data.rows = kRows;
  data.columns = {{{"t01", "degC"}, {}}, {{"t02", "degC"}, {}}, {{"t03", "degC"}, {}}};
  double air = 21, parts[] = {21, 21, 21};
  for (std::size_t row = 0; row < kRows; ++row) {
    air += (21 - air) / 5 - (is_door(row) ? door_k(random) : 0);
    data.time_s.push_back(20.0 * static_cast<double>(row));
    for (std::size_t k = 0; k < 3; ++k) {
      parts[k] += (air - parts[k]) * (1 - std::exp(-1 / kDelays_rows[k]));
      data.columns[k].values.push_back(parts[k] + 5e-4 * normal(random));
    }
  }
  return data;
}

TEST(DoorsOfARoom, MakeWhatTheOtherThermometersForetellWorseInTheirRows) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Dataset data = room(seed);
    std::vector<Sensor> sensors;
    for (auto& column : data.columns)
      sensors.push_back({&column, usual_change(column.values), {}, {}});
    const auto beyond = beyond_the_others(sensors, 0);
    const auto usual = usual_beside_others(sensors, 0, beyond);
    // Of what really is left there, by its own spread over all doors.
    double squares = 0, doors = 0, least = INFINITY;
    for (std::size_t row = 2 * kBetweenDoors; row + kBetweenDoors < kRows; ++row) {
      if (!is_door(row)) continue;
      squares += std::pow(own_change(beyond, row), 2);
      least = std::min(least, usual[row]);
      ++doors;
    }
    const double at_doors = std::sqrt(squares / doors), over_all = usual_change(beyond);
    EXPECT_GT(at_doors, 2 * over_all) << "seed " << seed;
    EXPECT_GT(least, 0.5 * at_doors) << "seed " << seed;
    EXPECT_EQ(*std::ranges::min_element(usual), over_all) << "seed " << seed;
  }
}

}  // namespace
}  // namespace doors_of_a_room_test
}  // namespace driftwise::diagnosis
