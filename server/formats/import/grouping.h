#pragma once
// Rows of one goal kept together: by what was commanded, within a tolerance.

#include <cstdint>
#include <vector>

#include "server/core/data/dataset.h"

namespace driftwise::formats {

// columns: the channels that make a goal, one value per row. A row joins the first group whose
// first row lies within `within` of it in every column, else it opens a new one; a missing value
// counts as a value of its own. Groups are numbered from 1 in the order of their first rows.
std::vector<std::int64_t> group_rows(const std::vector<const DatasetColumn*>& columns,
                                     std::size_t rows, double within);

// Which groups are for validation.
// Every n-th, beginning with the n-th.
bool is_nth_group(std::int64_t group, int every);
// By a hash of seed and number: about the given share of all groups, the same ones whatever else
// the file holds. Source of the mixing: splitmix64, public domain, S. Vigna 2015.
bool is_hashed_group(std::int64_t group, double share, std::uint64_t seed);

}  // namespace driftwise::formats
