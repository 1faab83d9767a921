#pragma once
// The simulated cell as a process sees it: the devices of a cell file on their ports, the control
// port, the clock and the one timer that wakes everything. One thread. Construction binds the
// ports; run() serves until stop().

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <memory>
#include <string>
#include <vector>

#include "drivers/simulated/emulators/cell/cell_outline.h"
#include "drivers/simulated/emulators/cell/device_bench.h"
#include "drivers/simulated/emulators/cell/emulator_options.h"
#include "drivers/simulated/emulators/cell/fault_desk.h"
#include "drivers/simulated/emulators/cell/sim_clock.h"
#include "drivers/simulated/emulators/cell/stream_server.h"

namespace driftwise::simulated {

class CellServer {
 public:
  struct Options {
    bool free_ports = false;  // else the addresses of the cell file
    std::uint64_t seed = 1;
  };
  // hooks.drop and hooks.pass are filled in here. Throws SetupError.
  CellServer(boost::asio::io_context& io, Plant& plant, SimClock& clock, const CellOutline& outline,
             const EmulatorOptions& options, FaultHooks hooks, Options how);
  ~CellServer();

  // Device id (or "control", "<id>-serial") and the address in use.
  const std::vector<std::pair<std::string, std::string>>& addresses() const { return addresses_; }
  void start();  // arms the timer: from here on time passes for the devices
  void stop();

 private:
  void serve(const std::string& id, std::unique_ptr<Emulator> emulator, const std::string& address,
             int max_clients, bool serial);
  void received(std::size_t device, Session session, std::string_view bytes);
  void wake();
  // Why not; empty: so much cell time has passed for plant and devices.
  std::string pass(double for_s);

  boost::asio::io_context& io_;
  Plant& plant_;
  SimClock& clock_;
  WireOptions wire_;
  DeviceBench bench_;
  std::vector<std::unique_ptr<StreamServer>> servers_;
  std::vector<std::pair<std::string, std::string>> addresses_;
  boost::asio::steady_timer timer_;
  PlantPlaces places_;
  bool started_ = false;
  int connected_ = 0;  // clients of devices
};

}  // namespace driftwise::simulated
