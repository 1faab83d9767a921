#include "server/formats/export/model_c_text.h"

#include "server/compensation/snapshot.h"
#include "server/core/channel.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {

std::string CInputs::expression(const std::string& symbol) const {
  for (std::size_t i = 0; i < pose.size(); ++i)
    if (pose[i].channel.symbol == symbol) return "pose[" + std::to_string(i) + "]";
  for (std::size_t i = 0; i < slow.size(); ++i)
    if (slow[i].channel.symbol == symbol) return "temperatures[" + std::to_string(i) + "]";
  return {};
}

std::vector<calibration::ChannelRange> CInputs::all() const {
  auto out = pose;
  out.insert(out.end(), slow.begin(), slow.end());
  return out;
}

std::string c_literal(double value) {
  std::string text = number_text(value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string c_power(const std::string& value, int exponent) {
  std::string out = value;
  for (int i = 1; i < exponent; ++i) out += " * " + value;
  return exponent > 1 ? "(" + out + ")" : out;
}

std::string c_replaced(std::string text, const std::string& what, const std::string& by) {
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
  return text;
}

std::string c_domain_tests(const CInputs& inputs, std::size_t first, std::size_t last) {
  const auto ranges = inputs.all();
  std::string code;
  for (std::size_t i = first; i < last; ++i) {
    const std::string value = inputs.expression(ranges[i].channel.symbol);
    const double slack = compensation::kDomainSlack * (ranges[i].max - ranges[i].min);
    code += "  if (!(" + value + " >= " + c_literal(ranges[i].min - slack) + " && " + value +
            " <= " + c_literal(ranges[i].max + slack) + ")) outside |= " + std::to_string(1u << i) +
            "; /* " + ranges[i].channel.name() + " */\n";
  }
  return code;
}

}  // namespace driftwise::formats
