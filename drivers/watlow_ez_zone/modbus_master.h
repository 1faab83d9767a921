#pragma once
// One unit on a Modbus line, libmodbus behind one small class: connects, reads and writes
// registers, keeps in step after a time-out. Blocks: call it on the line's thread.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/transport/address.h"
#include "drivers/transport/exchange_log.h"
#include "drivers/watlow_ez_zone/modbus_line.h"
#include "server/core/result.h"

namespace driftwise::watlow {

// Errors: unavailable (LINK_DOWN, LINK_LOST), deadline_exceeded (TIMEOUT), data_loss (BAD_REPLY:
// damaged frame), failed_precondition (MODBUS_EXCEPTION, with the exception's meaning). Each names
// device, address, unit and registers.
class ModbusMaster {
 public:
  struct Settings {
    std::string device, address_text;  // for messages
    transport::Address address;
    std::shared_ptr<ModbusLine> line;
    int unit_id = 1;
  };
  struct Figures {
    std::int64_t exchanges = 0, errors = 0;
    double last_latency_s = 0;
  };

  explicit ModbusMaster(Settings settings);
  ~ModbusMaster();
  ModbusMaster(const ModbusMaster&) = delete;
  ModbusMaster& operator=(const ModbusMaster&) = delete;

  bool connected() const { return line().context != nullptr && joined_ == line().connection; }
  Result<void> connect(std::chrono::nanoseconds timeout);
  void disconnect();  // leaves the line; others stay on it
  void set_timeout(std::chrono::nanoseconds timeout);

  Result<std::vector<std::uint16_t>> read(int address, int count);  // function 3
  Result<void> write(int address,
                     std::span<const std::uint16_t> registers);  // function 16, or 6 for one

  const Figures& figures() const { return figures_; }
  const transport::ExchangeLog& log() const { return log_; }

 private:
  ModbusLine& line() const { return *settings_.line; }
  Result<void> open();
  void close();           // for every unit of the line
  _modbus* ours() const;  // the line's context, told whom the next request is for
  tl::unexpected<Error> failed(int error_number, const std::string& what,
                               std::chrono::nanoseconds took);
  void wait_a_frame() const;
  void note(const std::string& what, std::string got, std::chrono::nanoseconds took,
            std::string outcome);

  Settings settings_;
  std::int64_t joined_ = 0;  // connection of the line
  std::chrono::nanoseconds timeout_{std::chrono::seconds(1)};
  Figures figures_;
  transport::ExchangeLog log_;
};

}  // namespace driftwise::watlow
