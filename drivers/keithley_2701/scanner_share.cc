#include "drivers/keithley_2701/scanner_share.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::keithley {
namespace {

tl::unexpected<Error> bad_input(const DeviceDescription& device, int input,
                                const std::string& expected) {
  return fail(ErrorCode::invalid_argument, reasons::kBadProbes,
              "device '" + device.id + "': input " + std::to_string(input) + ": " + expected);
}

}  // namespace

Result<void> ScannerShare::add(const DeviceDescription& device, ScanList list) {
  std::ranges::sort(list.inputs);
  for (std::size_t i = 0; i < list.inputs.size(); ++i) {
    const int input = list.inputs[i];
    if (input < 101 || input > 599 || (i > 0 && list.inputs[i - 1] == input))
      return bad_input(device, input, "expected 101 .. 599, each once");
    for (const auto& other : lists_)
      if (std::ranges::find(other.inputs, input) != other.inputs.end())
        return bad_input(
            device, input,
            "expected one that device '" + other.device + "' at the same address does not have");
  }
  for (const auto& [name, value] : device.options) {
    if (!is_of_connection(name)) continue;
    const auto [found, is_new] = stated_.try_emplace(name, value);
    if (!is_new && found->second != value)
      return fail(ErrorCode::invalid_argument, reasons::kBadOption,
                  "device '" + device.id + "': option " + name + " = '" + value + "', expected '" +
                      found->second + "' as device '" + who_[name] +
                      "' at the same address states it: it is one connection");
    who_.try_emplace(name, device.id);
  }
  const bool has_thermometers = list.function == ScanFunction::four_wire_ohms;
  if (!device_ || has_thermometers) device_ = device;
  lists_.insert(has_thermometers ? lists_.begin() : lists_.end(), std::move(list));
  return {};
}

Scanner& ScannerShare::scanner() {
  if (scanner_) return *scanner_;
  auto described = *device_;
  for (const auto& [name, value] : stated_) described.options[name] = value;
  // Each option was read before it was added.
  auto options =
      read_options(described, std::holds_alternative<transport::SerialAddress>(address_));
  scanner_ = std::make_unique<Scanner>(*device_, options ? std::move(*options) : Options{}, lists_,
                                       address_, executor_, clock_);
  return *scanner_;
}

std::size_t ScannerShare::list_of(const std::string& device) const {
  return static_cast<std::size_t>(std::ranges::find(lists_, device, &ScanList::device) -
                                  lists_.begin());
}

}  // namespace driftwise::keithley
