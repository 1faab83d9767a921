#pragma once
// Sections that the plant files of both deltas on flexures have.

#include "drivers/simulated/plant/file/plant_sections.h"
#include "drivers/simulated/plant/micro_nano/micro_nano_parameters.h"

namespace driftwise::simulated {

Vec3 vector_of(Fields& fields, std::string_view key);

// Of [delta] and [optics] what both have; the caller reads the rest and finishes the table.
DeltaParameters flexure_delta_section(Fields& fields, const Materials& materials,
                                      const std::vector<PartParameters>& parts);
OpticsParameters optics_section(Fields& fields);

// Whole sections.
ToleranceParameters tolerance_section(Fields fields);
CubeParameters cube_section(Fields fields);
CollimatorParameters collimator_section(Fields fields, const std::vector<PartParameters>& parts);

// [beam.x], [beam.y], [beam.z] with what [interferometer] says of all; signs: of what is shown, +
// when the mirror goes away from the head.
void beam_sections(Fields fields, Fields common, const PerArm<double>& signs, CellParameters& plant,
                   PerArm<BeamParameters>& beams);
// [loop.*]: what a beam is tied to.
void loop_sections(Fields fields, const Materials& materials,
                   const std::vector<PartParameters>& parts, PerArm<BeamParameters>& beams);

}  // namespace driftwise::simulated
