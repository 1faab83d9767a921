#pragma once
// A quantity as people read it: plain digits, no exponent, one unit for what is compared.

#include <initializer_list>
#include <string>
#include <string_view>

namespace driftwise {

// Rounded to at most so many significant digits and written out: "82300", "12.8", "0.574", "42",
// "+24.3" with a sign, which zero has not. An exponent only below 1e-4 and from 1e15 on; "-" for
// what is not finite.
std::string digits_text(double value, int significant = 3, bool sign = false);

// A mean beside the A90 of the same errors, to the last of the A90's three significant digits:
// "+24.3" beside 42.0, "+0.62" beside 9.24, "0" where it is less than that. Finer digits of a mean
// say nothing, and those of one that a fit makes zero are the machine's rounding.
std::string mean_text(double mean, double a90);

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
