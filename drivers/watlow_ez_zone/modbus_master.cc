#include "drivers/watlow_ez_zone/modbus_master.h"

#include <modbus/modbus.h>

#include <cerrno>
#include <cstdio>
#include <thread>

#include "server/core/reasons.h"

namespace driftwise::watlow {
namespace {

using SteadyClock = std::chrono::steady_clock;

std::string registers_text(const char* verb, int address, int count) {
  std::string out =
      std::string(verb) + " register" + (count == 1 ? " " : "s ") + std::to_string(address);
  if (count > 1) out += ".." + std::to_string(address + count - 1);
  return out;
}

std::string words_text(std::span<const std::uint16_t> words) {
  std::string out;
  for (const auto word : words) {
    char text[8];
    std::snprintf(text, sizeof text, "%s%04x", out.empty() ? "" : " ", static_cast<unsigned>(word));
    out += text;
  }
  return out;
}

bool is_exception(int number) { return number > MODBUS_ENOBASE && number < EMBBADCRC; }

}  // namespace

void ModbusLine::Free::operator()(_modbus* context) const {
  modbus_close(context);
  modbus_free(context);
}

ModbusMaster::ModbusMaster(Settings settings) : settings_(std::move(settings)) {}
ModbusMaster::~ModbusMaster() = default;

void ModbusMaster::disconnect() {
  if (connected() && --line().units == 0) close();
  joined_ = 0;
}

void ModbusMaster::close() {
  line().context.reset();
  line().units = 0;
}

void ModbusMaster::set_timeout(std::chrono::nanoseconds timeout) { timeout_ = timeout; }

_modbus* ModbusMaster::ours() const {
  _modbus* const context = line().context.get();
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(timeout_).count();
  modbus_set_response_timeout(context, static_cast<std::uint32_t>(us / 1'000'000),
                              static_cast<std::uint32_t>(us % 1'000'000));
  modbus_set_slave(context, settings_.unit_id);
  return context;
}

Result<void> ModbusMaster::connect(std::chrono::nanoseconds timeout) {
  set_timeout(timeout);
  if (connected()) return {};
  if (!line().context) {
    if (auto up = open(); !up) return up;
    ++line().connection;
  }
  joined_ = line().connection;
  ++line().units;
  return {};
}

Result<void> ModbusMaster::open() {
  const auto started = SteadyClock::now();
  if (const auto* tcp = std::get_if<transport::TcpAddress>(&settings_.address)) {
    line().context.reset(modbus_new_tcp_pi(tcp->host.c_str(), std::to_string(tcp->port).c_str()));
  } else {
    const auto& serial = line().serial;
    const char parity = serial.parity == transport::Parity::none   ? 'N'
                        : serial.parity == transport::Parity::even ? 'E'
                                                                   : 'O';
    line().context.reset(
        modbus_new_rtu(std::get<transport::SerialAddress>(settings_.address).path.c_str(),
                       serial.baud, parity, serial.data_bits, serial.stop_bits));
  }
  if (!line().context) return failed(errno, "set up a Modbus line", {});
  errno = 0;
  if (modbus_connect(ours()) != 0) {
    // For a name that does not resolve errno says nothing useful.
    const int number = errno != 0 ? errno : EHOSTUNREACH;
    close();
    return failed(number, "connect", SteadyClock::now() - started);
  }
  return {};
}

Result<std::vector<std::uint16_t>> ModbusMaster::read(int address, int count) {
  const std::string what = registers_text("read", address, count);
  if (!connected()) return failed(ENOTCONN, what, {});
  std::vector<std::uint16_t> out(static_cast<std::size_t>(count));
  const auto started = SteadyClock::now();
  const int got = modbus_read_registers(ours(), address, count, out.data());
  const int number = errno;
  const auto took = SteadyClock::now() - started;
  if (got != count) return failed(got < 0 ? number : EMBBADDATA, what, took);
  note(what, words_text(out), took, "");
  return out;
}

Result<void> ModbusMaster::write(int address, std::span<const std::uint16_t> registers) {
  const int count = static_cast<int>(registers.size());
  const std::string what = registers_text("write", address, count) + " = " + words_text(registers);
  if (!connected()) return failed(ENOTCONN, what, {});
  const auto started = SteadyClock::now();
  const int done = count == 1 ? modbus_write_register(ours(), address, registers[0])
                              : modbus_write_registers(ours(), address, count, registers.data());
  const int number = errno;
  const auto took = SteadyClock::now() - started;
  if (done != count) return failed(done < 0 ? number : EMBBADDATA, what, took);
  note(what, "ok", took, "");
  return {};
}

tl::unexpected<Error> ModbusMaster::failed(int number, const std::string& what,
                                           std::chrono::nanoseconds took) {
  char time[32];
  std::snprintf(time, sizeof time, "%.0f ms", static_cast<double>(took.count()) * 1e-6);
  const std::string cause = modbus_strerror(number);
  const std::string where = "device '" + settings_.device + "' at " + settings_.address_text +
                            ", unit " + std::to_string(settings_.unit_id) + ": " + what;
  Error error{ErrorCode::unavailable, reasons::kLinkLost, where + ": " + cause + " after " + time};
  if (is_exception(number)) {
    error = {ErrorCode::failed_precondition, reasons::kModbusException,
             where + ": the device answered exception " + std::to_string(number - MODBUS_ENOBASE) +
                 " (" + cause + ")"};
  } else if (number == ETIMEDOUT || number == EMBBADCRC || number == EMBBADDATA ||
             number == EMBBADSLAVE || number == EMBBADEXC || number == EMBMDATA ||
             number == EMBUNKEXC) {
    const bool silent = number == ETIMEDOUT;
    if (line().context && !silent) wait_a_frame();
    // A late answer must not be taken for the next one: a TCP line starts over, a serial one waits
    // for silence.
    if (std::holds_alternative<transport::TcpAddress>(settings_.address)) {
      disconnect();
    } else if (line().context) {
      wait_a_frame();
      modbus_flush(line().context.get());
    }
    error = silent ? Error{ErrorCode::deadline_exceeded, reasons::kTimeout,
                           where + ": no answer within " + time +
                               "; another unit's address, baud rate or parity stays silent too"}
                   : Error{ErrorCode::data_loss, reasons::kBadReply,
                           where + ": " + cause + " after " + time};
  } else {
    if (what == "connect" || number == ENOTCONN) error.reason = reasons::kLinkDown;
    if (number != ENOTCONN) close();  // broken, and for every unit
    joined_ = 0;
  }
  ++figures_.errors;
  note(what, "", took, error.message);
  return tl::unexpected(error);
}

// The longest Modbus frame (256 bytes of 11 bits) at the line's speed, at least 20 ms.
void ModbusMaster::wait_a_frame() const {
  const double frame_s = std::holds_alternative<transport::SerialAddress>(settings_.address)
                             ? 256.0 * 11.0 / line().serial.baud
                             : 0.0;
  std::this_thread::sleep_for(std::chrono::duration<double>(std::max(frame_s, 0.02)));
}

void ModbusMaster::note(const std::string& what, std::string got, std::chrono::nanoseconds took,
                        std::string outcome) {
  ++figures_.exchanges;
  figures_.last_latency_s = static_cast<double>(took.count()) * 1e-9;
  log_.add({figures_.exchanges, what, std::move(got), took, std::move(outcome)});
}

}  // namespace driftwise::watlow
