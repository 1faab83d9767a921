#pragma once
// A quantity as people read it: plain digits, no exponent, one unit for what is compared.

#include <initializer_list>
#include <string>
#include <string_view>

namespace driftwise {

// Rounded to at most so many significant digits and written out: "82300", "12.8", "0.574", "42",
// "+24.3" with a sign. An exponent only below 1e-4 and from 1e15 on; "-" for what is not finite.
std::string digits_text(double value, int significant = 3, bool sign = false);

// The unit in which sizes that stand together are all written: of lengths in nm, "nm" while the
// largest is below 10 000 nm, "um" below 1 mm, else "mm"; any other unit stays.
// in_unit = factor * in_given.
struct SizeUnit {
  std::string unit;
  double factor = 1;
};
SizeUnit size_unit(std::initializer_list<double> sizes, std::string_view unit);

// "41.3 nm", "432 um", "12 arcsec": one size by itself.
std::string quantity_text(double size, std::string_view unit, int significant = 3);

}  // namespace driftwise
