#pragma once
// What a coarse grid cannot tell apart: a period, and the shorter ones that look the same where the
// points are.

#include <vector>

namespace driftwise::diagnosis {

// The spacing of a grid that all values sit on, as far as `loose` allows; 0 where they sit on none.
// Missing values are passed over.
double lattice_spacing(const std::vector<double>& values, double loose);

// The periods that have the values of `period` on every multiple of `spacing`: 1 / (k / spacing +-
// 1 / period), k from 1 to 3, the longest first. None for a spacing of 0.
std::vector<double> aliased_periods(double period, double spacing);

// The longest period that looks like this one on the lattice, and the first of those that are
// aliases of it; without the period itself. None for a spacing of 0.
std::vector<double> alike_on_a_lattice(double period, double spacing);

}  // namespace driftwise::diagnosis
