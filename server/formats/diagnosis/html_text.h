#pragma once
// Text as an HTML page shows it.

#include <string>
#include <string_view>

namespace driftwise::formats {

// & < > " ' as entities; safe as text and inside quoted attributes.
std::string html_escaped(std::string_view text);

// For people: about `digits` significant ones, a true minus, thin spaces between thousands, "-" for
// what is not a number. 18301.2 with 3 digits is "18 301": whole digits are never rounded away.
std::string figure_text(double value, int digits = 3);
// The same with so many decimals; none for less than 0.
std::string fixed_text(double value, int decimals);

// "p < 0.001", "p = 0.004"
std::string chance_text(double p);

}  // namespace driftwise::formats
