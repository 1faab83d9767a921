#pragma once
// Values as a message shows them.

#include <string>
#include <string_view>

namespace driftwise {

// Found text: in quotes, unprintable bytes as \xHH, cut after 40 characters.
std::string shown(std::string_view text);

// Shortest digits that read back as the same double; "not a number" for NaN and the infinities.
std::string number_text(double value);

}  // namespace driftwise
