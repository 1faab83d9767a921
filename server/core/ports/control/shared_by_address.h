#pragma once
// What several devices of a cell share because one instrument stands behind them, at one address: a
// scanner whose inputs are thermometers of one [[device]] and voltages of another.

#include <map>
#include <memory>
#include <string>
#include <typeindex>
#include <utility>

namespace driftwise {

// Lives while the devices of a cell are made; what is shared lives as long as a device that has it.
class SharedByAddress {
 public:
  // The Shared of this address, made by make() when no device has it yet.
  template <class Shared, class Make>
  std::shared_ptr<Shared> find_or(const std::string& address, Make make) {
    auto& place = shared_[{address, std::type_index(typeid(Shared))}];
    if (auto found = std::static_pointer_cast<Shared>(place.lock())) return found;
    std::shared_ptr<Shared> made = make();
    place = made;
    return made;
  }

 private:
  std::map<std::pair<std::string, std::type_index>, std::weak_ptr<void>> shared_;
};

}  // namespace driftwise
