#pragma once
// Where the hidden robots go and when, and the room they stand in.

#include <array>
#include <random>
#include <vector>

#include "tests/hidden_effects/shapes/hidden_world.h"

namespace driftwise::hidden {

struct Path {
  std::vector<double> time_s, dwell_s, force_n;
  std::vector<std::array<double, 3>> at_mm;  // x y z; the linear axis uses x
  std::vector<bool> calibration;
  std::size_t rows() const { return time_s.size(); }
};

// Linear axis: 56 passes of 18 positions over 8 mm, up and down in turn: 1008 rows. Micro-Nano:
// lines through a 2.5 mm cube in random order under eight changing loads: 1056 rows.
Path make_path(Robot robot, std::mt19937_64& random);

// Every second from 0 to the end: a room that drifts and swings, and sensors behind bodies of
// different mass.
struct Weather {
  std::vector<std::vector<double>> sensor_degc;  // [sensor][second]
  std::vector<double> air_degc, pressure_hpa, humidity_pct;
};
Weather make_weather(int sensors, double end_s, std::mt19937_64& random);

double at_time(const std::vector<double>& by_second, double time_s);

}  // namespace driftwise::hidden
