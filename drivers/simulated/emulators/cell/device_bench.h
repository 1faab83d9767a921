#pragma once
// The emulated devices together, on one plant and one time. Everything that is due runs in the
// order of its time across all devices before anything later happens, so the plant is only ever
// asked forwards; replies pass the device's faults and go to the wire. No sockets and no clock
// here: the caller says what time it is. One thread.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "drivers/simulated/emulators/cell/faults.h"
#include "drivers/simulated/emulators/emulator.h"

namespace driftwise::simulated {

class DeviceBench {
 public:
  // Called for every piece that leaves a device, in order of time.
  using Deliver = std::function<void(std::size_t device, Session session, std::string bytes)>;

  explicit DeviceBench(Plant& plant) : plant_(plant) {}
  std::size_t add(std::string id, std::unique_ptr<Emulator> emulator);
  void set_deliver(Deliver deliver) { deliver_ = std::move(deliver); }

  std::size_t size() const { return devices_.size(); }
  const std::string& id(std::size_t device) const { return devices_[device].id; }
  std::optional<std::size_t> find(const std::string& id) const;
  Faults& faults(std::size_t device) { return devices_[device].faults; }
  bool set_clock(std::size_t device, TimeNs ahead) {
    return devices_[device].emulator->set_clock(ahead);
  }

  void open(std::size_t device, Session session, Link link, TimeNs now);
  void close(std::size_t device, Session session, TimeNs now);
  void receive(std::size_t device, Session session, std::string_view bytes, TimeNs now);
  // Runs what is due until now, then brings the plant there.
  void run_until(TimeNs now);
  std::optional<TimeNs> next_event() const;

 private:
  struct Device {
    std::string id;
    std::unique_ptr<Emulator> emulator;
    Faults faults;
  };
  void collect(std::size_t device);

  Plant& plant_;
  std::vector<Device> devices_;
  Timeline delayed_;  // replies that a fault holds back
  Deliver deliver_;
};

}  // namespace driftwise::simulated
