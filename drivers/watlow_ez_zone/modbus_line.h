#pragma once
// The one connection and the one thread of the units on a Modbus line. On an RTU bus every unit
// hears every byte: two that are asked at once destroy one another's answers.

#include <boost/asio/thread_pool.hpp>
#include <cstdint>
#include <memory>

#include "drivers/transport/address.h"

struct _modbus;

namespace driftwise::watlow {

struct ModbusLine {
  struct Free {
    void operator()(_modbus* context) const;
  };

  explicit ModbusLine(transport::SerialSettings settings) : serial(settings) {}
  ~ModbusLine() { thread.join(); }

  const transport::SerialSettings serial;
  // On the thread only.
  std::unique_ptr<_modbus, Free> context;
  std::int64_t connection = 0;  // counts them; a unit knows by it whether it joined this one
  int units = 0;                // that have joined it: the last one to leave closes it

  boost::asio::thread_pool thread{1};  // last: joined before anything it uses is gone
};

}  // namespace driftwise::watlow
