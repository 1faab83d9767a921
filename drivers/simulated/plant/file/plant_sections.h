#pragma once
// The sections of a plant file that every robot's has, and what the robots' own readers share.

#include <map>
#include <string>
#include <vector>

#include "drivers/simulated/plant/file/plant_fields.h"
#include "drivers/simulated/plant/plant_parameters.h"

namespace driftwise::simulated {

using Materials = std::map<std::string, Material, std::less<>>;

// Of [material], [part], [link], [room], [scanner], [thermometer] and the times of [plant] into
// `cell`; returns the materials. head is [plant]; its kind has been read.
Materials cell_sections(Fields& root, Fields& head, CellParameters& cell);

// Sections that name their own parts or come several times: what all of them have. The caller reads
// the rest of the table and finishes it.
AxisParameters axis_section(Fields& fields);
RoomParameters room_section(Fields fields);
InterferometerParameters interferometer_section(Fields& fields,
                                                const std::vector<PartParameters>& parts);
StabiliserParameters stabiliser_section(Fields& fields);

// Of [voltage] into `cell`, whose axes are known.
void voltage_sections(Fields& root, CellParameters& cell);

// Node of the part that the key names; fails when there is none.
int part_named(Fields& fields, std::string_view key, const std::vector<PartParameters>& parts);
std::vector<int> parts_named(Fields& fields, std::string_view key,
                             const std::vector<PartParameters>& parts);
int part_index(const Fields& fields, std::string_view key, std::string_view name,
               const std::vector<PartParameters>& parts);
const Material& material_named(Fields& fields, std::string_view key, const Materials& materials);
// Of the key's material, 1/K.
double expansion_named(Fields& fields, std::string_view key, const Materials& materials);

}  // namespace driftwise::simulated
