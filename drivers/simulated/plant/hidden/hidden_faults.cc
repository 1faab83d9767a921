#include "drivers/simulated/plant/hidden/hidden_faults.h"

namespace driftwise::simulated {

using Fault = HiddenThermometer::Fault;

HiddenFaults::HiddenFaults(std::span<const Hidden> hidden) {
  for (const Hidden& one : hidden) {
    if (const auto* fault = std::get_if<HiddenThermometer>(&one.effect)) faults_.push_back(*fault);
  }
}

int HiddenFaults::connected(int input, double time_s) const {
  for (const auto& fault : faults_) {
    if (fault.fault != Fault::swapped || time_s < 3600 * fault.at_h) continue;
    if (fault.input == input) return fault.other;
    if (fault.other == input) return fault.input;
  }
  return input;
}

double HiddenFaults::shown_ohm(int input, double time_s, double ohm, double r0_ohm) {
  for (const auto& fault : faults_) {
    if (fault.input != input || time_s < 3600 * fault.at_h) continue;
    if (fault.fault == Fault::stuck) ohm = stuck_ohm_.try_emplace(input, ohm).first->second;
    if (fault.fault == Fault::jump) ohm += fault.size;
    if (fault.fault == Fault::gain) ohm = r0_ohm + fault.size * (ohm - r0_ohm);
  }
  return ohm;
}

}  // namespace driftwise::simulated
