#pragma once
// Pieces of the C source that write_model_c() puts together.

#include <string>
#include <vector>

#include "server/calibration/model/model.h"

namespace driftwise::formats {

// Inputs of the function, in order of the model's domain: pose and force, then the rest.
struct CInputs {
  std::vector<calibration::ChannelRange> pose, slow;

  std::string expression(const std::string& symbol) const;  // "pose[1]"; empty: no input
  std::vector<calibration::ChannelRange> all() const;
};

std::string c_literal(double value);  // reads back exactly

// "(pose[0] * pose[0])": a power as effects::power multiplies it.
std::string c_power(const std::string& value, int exponent);

std::string c_replaced(std::string text, const std::string& what, const std::string& by);

// "if (!(pose[0] >= -1.01 && pose[0] <= 1.01)) outside |= 1;" for the inputs [first, last) of
// all(): the ranges -1 .. 1 with the slack that targets have (compensation::kDomainSlack).
std::string c_domain_tests(const CInputs& inputs, std::size_t first, std::size_t last);

}  // namespace driftwise::formats
