#pragma once
// The side, robot or instrument, on which a finding is taken that may be either's error. Pure.
//
// Two things tell them apart: what the caller says, and for a jump the outputs. An instrument that
// jumps shows in every output in the proportion of the slopes of its axis, a motor that slips in
// its own output alone. Where each output follows one axis both are the same.

#include <optional>
#include <string>

#include "server/application/diagnoses/instrument_agreement.h"
#include "server/application/diagnoses/whose.h"
#include "server/core/data/dataset.h"
#include "server/core/result.h"
#include "server/diagnosis/answer/diagnosis.h"

namespace driftwise::application {

// Lead of one explanation of a jump over the other, in 2 ln L, from which it is taken for known.
inline constexpr double kTold2lnl = 12;

// The finding is what its name says: it was chosen by its number.
inline constexpr const char* kAsNamed = "named";

// claim: of all axes of the simulation. Nothing: the outputs do not tell.
std::optional<Side> side_of_jump(const diagnosis::Finding& finding, const InstrumentClaim& claim);

// The finding as it is taken: itself, or another cause of its set with the terms and amplitudes
// that the data give that one. taken_as: "robot", "instrument" or a cause; a side stands for the
// finding itself, if it is of that side, else for the first cause of the set that is. Errors:
// failed_precondition NO_SUCH_FINDING; those of diagnosis::open_hypotheses.
Result<diagnosis::Finding> taken_as(const diagnosis::Diagnosis& found, int number,
                                    const std::string& taken_as, const Dataset& data);

// INDISTINGUISHABLE: what it may be, what to measure, how to insist.
Error side_unknown(DiagnosisId id, const diagnosis::Diagnosis& found, int number);

}  // namespace driftwise::application
