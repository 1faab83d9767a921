#pragma once
// Sentences about differences of the cell file and about corrections in force, shared by the pages
// of runs and models and by `driftwise configuration`.

#include <string>
#include <vector>

#include "driftwise/v1/provenance.pb.h"

namespace driftwise::cli {

// "probe t07_degC: input 107 -> 108", those that ask for a person first.
std::string change_text(const v1::ConfigurationChange& change);
// "correction 3 of diagnosis 5, in force since 2026-11-22 09:12:03 by ada"; and what it changes.
std::vector<std::string> mark_texts(const v1::CorrectionMark& mark);
// "x_mm of run 3 'weekend' by up to 3219 nm (rms 812 nm) in 200 rows"
std::string length_text(const v1::LengthChange& change);

}  // namespace driftwise::cli
