#pragma once
// Allan deviation of evenly spaced values.
//
// Source: W. J. Riley, Handbook of Frequency Stability Analysis, NIST Special Publication 1065
// (2008): overlapping Allan variance, section 5.2.4 (5.7 for values in place of frequencies); its
// 1000-point data set is the test.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace driftwise::stability {

struct AllanPoint {
  std::size_t factor = 1;    // values that are averaged
  double tau_s = 0;          // factor times the interval
  double deviation = 0;      // in the unit of the values
  double low = 0, high = 0;  // 68 % interval
  std::size_t terms = 0;     // second differences in the sum
};

// sigma^2(m) = sum over j of (mean of m values from j + m on minus mean of m values from j on)^2
// divided by twice their number. factors: each from 1 to half the number of values. The interval
// counts the independent differences only: values / factor - 1 of them, at least 1.
std::vector<AllanPoint> allan_deviation(std::span<const double> values, double interval_s,
                                        std::span<const std::size_t> factors);

// 1, 2, 4, ... up to a quarter of the number of values.
std::vector<std::size_t> octaves(std::size_t values);

// A sentence on the kind of noise, by the slope of log sigma over log tau: white (-1/2), flicker
// (0), random walk (1/2), drift (1), at the shortest and at the longest times, and the averaging
// time with the smallest deviation.
std::string noise_sentence(std::span<const AllanPoint> points);

}  // namespace driftwise::stability
