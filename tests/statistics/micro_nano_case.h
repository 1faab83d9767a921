#pragma once
// The Micro-Nano of case B as a cell sees it, judged by its plant's truth.

#include <cstdint>
#include <vector>

#include "tests/statistics/served_case.h"
#include "tests/support/micro_nano_campaign.h"

namespace driftwise::statistics {

// Rows of a campaign as the cell would export them: lengths corrected with the cell's own offsets
// and directions, q1..q3, x y z, rx ry rz, force, t01..t10, times and sets.
Dataset micro_nano_dataset(const std::vector<testing_support::MicroNanoRow>& rows,
                           const CellDescription& cell);

CellDescription micro_nano_cell();  // deploy/cells/micro-nano/cell.toml; throws when it is wrong

// The published campaign with this seed (another machine, other mirrors, offsets and weather), its
// first four grids, and after every line one pose anywhere in the workspace that the fit does not
// see: 133 targets, spread over poses, temperatures and forces as the calibration is, each judged
// at its own time.
SimulatedCase micro_nano_case(std::uint64_t seed);

// The same on another plant: "section.key=value" over the plant's file, after the campaign's own.
SimulatedCase micro_nano_case_with(std::uint64_t seed, const std::vector<std::string>& overrides);

}  // namespace driftwise::statistics
