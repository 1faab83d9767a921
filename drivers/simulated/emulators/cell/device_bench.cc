#include "drivers/simulated/emulators/cell/device_bench.h"

namespace driftwise::simulated {

std::size_t DeviceBench::add(std::string id, std::unique_ptr<Emulator> emulator) {
  devices_.push_back({std::move(id), std::move(emulator), {}});
  return devices_.size() - 1;
}

std::optional<std::size_t> DeviceBench::find(const std::string& id) const {
  for (std::size_t i = 0; i < devices_.size(); ++i)
    if (devices_[i].id == id) return i;
  return std::nullopt;
}

void DeviceBench::open(std::size_t device, Session session, Link link, TimeNs now) {
  run_until(now);
  devices_[device].emulator->open(session, link, now);
}

void DeviceBench::close(std::size_t device, Session session, TimeNs now) {
  run_until(now);
  devices_[device].emulator->close(session, now);
}

void DeviceBench::receive(std::size_t device, Session session, std::string_view bytes, TimeNs now) {
  run_until(now);
  if (devices_[device].faults.mute(now)) return;
  devices_[device].emulator->receive(session, bytes, now);
  collect(device);
}

void DeviceBench::run_until(TimeNs now) {
  for (;;) {
    // Held-back replies first: at one instant they were said before anything new.
    std::optional<TimeNs> first = delayed_.next();
    std::optional<std::size_t> device;
    for (std::size_t i = 0; i < devices_.size(); ++i) {
      const auto next = devices_[i].emulator->next_event();
      if (next && (!first || *next < *first)) first = next, device = i;
    }
    if (!first || *first > now) break;
    if (!device) {
      delayed_.run_next();
      continue;
    }
    devices_[*device].emulator->run_next_event();
    collect(*device);
  }
  plant_.advance_to(now);
}

std::optional<TimeNs> DeviceBench::next_event() const {
  std::optional<TimeNs> first = delayed_.next();
  for (const auto& device : devices_) {
    const auto next = device.emulator->next_event();
    if (next && (!first || *next < *first)) first = next;
  }
  return first;
}

void DeviceBench::collect(std::size_t device) {
  Faults& faults = devices_[device].faults;
  for (auto& output : devices_[device].emulator->take_output()) {
    if (faults.mute(output.at)) continue;
    if (faults.garbles(output.at)) output.bytes = faults.garbled(std::move(output.bytes));
    if (faults.slow_ns == 0) {
      if (deliver_) deliver_(device, output.session, std::move(output.bytes));
      continue;
    }
    delayed_.at(output.at + faults.slow_ns,
                [this, device, session = output.session, bytes = std::move(output.bytes)](TimeNs) {
                  if (deliver_) deliver_(device, session, bytes);
                });
  }
}

}  // namespace driftwise::simulated
