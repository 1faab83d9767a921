#pragma once
// A Watlow EZ-ZONE PM behind Modbus: TCP frames (MBAP header) on TCP sessions, RTU frames (address,
// CRC) on the serial one. Functions 3, 6, 16; exceptions 1 function, 2 address, 3 value. A request
// to another unit id, a frame with a wrong CRC or protocol id gets silence. A TCP length field that
// cannot be is followed by nothing sensible: the bytes received so far are dropped.
//
// RTU framing: the length follows from the function code; a frame of an unknown function and one
// that is unfinished end with a silence of rtu_gap_s. (3.5 characters, as the standard asks, cannot
// be seen through an operating system.)

#include <cstdint>
#include <map>
#include <string>

#include "drivers/simulated/emulators/emulator.h"
#include "drivers/simulated/emulators/watlow_ez_zone/watlow_registers.h"

namespace driftwise::simulated {

std::uint16_t modbus_crc(std::string_view bytes);  // CRC-16, polynomial 0xA001, start 0xFFFF

class WatlowEmulator : public Emulator {
 public:
  // Throws SetupError.
  WatlowEmulator(PlantStabilisers& plant, const Switches& switches, int first, TimeNs power_on);

  void open(Session session, Link link, TimeNs now) override;
  void close(Session session, TimeNs now) override;
  void receive(Session session, std::string_view bytes, TimeNs now) override;

 private:
  struct Client {
    Link link;
    std::string input;
    Timeline::EventId gap{};
  };

  void tcp_frames(Session session, Client& client, TimeNs now);
  void rtu_frames(Session session, Client& client, bool silence, TimeNs now);
  // The answer to one request (function code and data), or its exception.
  std::string answer(std::string_view pdu, TimeNs now);
  void reply(Session session, std::string frame, TimeNs now);

  WatlowRegisters registers_;
  int unit_;
  TimeNs latency_, gap_;
  std::map<Session, Client> clients_;
};

}  // namespace driftwise::simulated
