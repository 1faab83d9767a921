#pragma once
// The sections of a plant file, one function for those that depend on names defined elsewhere.

#include "drivers/simulated/plant/plant_fields.h"
#include "drivers/simulated/plant/plant_parameters.h"

namespace driftwise::simulated {

PlantParameters plant_sections(Fields root);

// The plain sections: numbers and part names only.
AxisParameters axis_section(Fields fields, const std::vector<PartParameters>& parts);
RoomParameters room_section(Fields fields);
InterferometerParameters interferometer_section(Fields fields,
                                                const std::vector<PartParameters>& parts);
StabiliserParameters stabiliser_section(Fields fields, const std::vector<PartParameters>& parts);

// Node of the part that the key names; fails when there is none.
int part_named(Fields& fields, std::string_view key, const std::vector<PartParameters>& parts);
int part_index(const Fields& fields, std::string_view key, std::string_view name,
               const std::vector<PartParameters>& parts);

}  // namespace driftwise::simulated
