#pragma once
// "x=1.5" on the command line -> a named value in the channel's unit.

#include <google/protobuf/repeated_field.h>

#include <string>
#include <vector>

#include "driftwise/v1/values.pb.h"

namespace driftwise::cli {

// "x=1.5", "x_mm=1.5", "x=1.5mm", "q1=0.25", "ry=12", "force=0.3": lengths in mm, rotations in
// arcsec, force in N. Throws Failure (usage) naming the text and what was expected.
v1::ChannelValue assignment_from(const std::string& text);
// Several assignments. Throws Failure (usage) also where one coordinate is given twice.
google::protobuf::RepeatedPtrField<v1::ChannelValue> assignments_from(
    const std::vector<std::string>& texts);

}  // namespace driftwise::cli
