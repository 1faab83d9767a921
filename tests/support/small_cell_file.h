#pragma once
// The small world's cell as a cell file, so that it can be changed as a person changes it.

#include <string>

#include "server/core/description/cell_description.h"

namespace driftwise::tests {

// small_cell() as text: an axis, five thermometers (t05 on the instrument, the others on the
// robot), a laser, a stabiliser. database: absolute.
std::string small_cell_text(const std::string& database);
// Throws what is wrong with it.
CellDescription cell_of(const std::string& text);
// The text with one piece of it replaced; throws when it is not there.
std::string replaced(std::string text, const std::string& from, const std::string& to);

}  // namespace driftwise::tests
