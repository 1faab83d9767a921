#pragma once
// The two robots of joint_plant calibrated by the study's campaigns (chapter 7): their models, the
// cell that declares their instruments, the plan that serves both. Lengths in mm, rotations in
// arcsec.

#include <cstdint>

#include "server/calibration/fit.h"
#include "server/plans/plan_check.h"
#include "tests/hidden_effects/joint/two_robot_plant.h"

namespace driftwise::plans::joint_use {

inline constexpr ModelId kMicroNanoModel{12}, kFineModel{11}, kCoarseModel{10}, kSideways{13},
    kTilts{14};

// study: the terms and plans of chapter 7. complete: what these plants do is in the terms. The
// MinAngle's models also have the temperature beside its screws, and its sideways motion is
// measured with its tilts and has terms for them. The Micro-Nano's have the fourth degree: what
// arms of 70 mm do over 2.5 mm and a cubic cannot is 10 nm at the zero, which is a corner. And they
// have products of temperature and pose: expansion moves the place on the arms' curve, by which the
// motors then differ, 1.5 um of 70 mm at 2.5 mm: 54 nm.
enum class Knowledge { study, complete };

struct Machine {
  explicit Machine(std::uint64_t seed) : a(seed), m(seed + 1000), see(seed + 2000) {}
  joint_plant::MicroNano a;
  joint_plant::MinAngle m;
  joint_plant::Instruments see;
};

// The Micro-Nano: four grids of 6^3 in a room that warms by 1.5 K; tilts: its rotations, one grid.
calibration::Model micro_nano_model(Machine& plant, joint_plant::Room room, bool tilts,
                                    Knowledge knowledge,
                                    calibration::Select of_tilts = calibration::Select::stepwise);

// All models of both robots by the seeds that follow this one.
ModelsById models_of(Machine& plant, std::uint64_t seed, Knowledge knowledge);

// Cell that declares the plant's instruments, each with the noise of one reading. Nothing is
// declared of the scales: their counts are the positions of the motors, by the plant's own word.
CellDescription cell_of_both();

// Coarse and fine model of the MinAngle blended; parasitic translations to the Micro-Nano, its
// tilts to the MinAngle.
ServingPlan plan_of(bool translations, bool tilts);

}  // namespace driftwise::plans::joint_use
