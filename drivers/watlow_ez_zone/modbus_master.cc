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

void ModbusMaster::Free::operator()(_modbus* context) const {
  modbus_close(context);
  modbus_free(context);
}

ModbusMaster::ModbusMaster(Settings settings) : settings_(std::move(settings)) {}
ModbusMaster::~ModbusMaster() = default;

void ModbusMaster::disconnect() { context_.reset(); }

void ModbusMaster::set_timeout(std::chrono::nanoseconds timeout) {
  timeout_ = timeout;
  if (!context_) return;
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(timeout).count();
  modbus_set_response_timeout(context_.get(), static_cast<std::uint32_t>(us / 1'000'000),
                              static_cast<std::uint32_t>(us % 1'000'000));
}

Result<void> ModbusMaster::connect(std::chrono::nanoseconds timeout) {
  if (context_) return {};
  const auto started = SteadyClock::now();
  if (const auto* tcp = std::get_if<transport::TcpAddress>(&settings_.address)) {
    context_.reset(modbus_new_tcp_pi(tcp->host.c_str(), std::to_string(tcp->port).c_str()));
  } else {
    const auto& line = settings_.serial;
    const char parity = line.parity == transport::Parity::none   ? 'N'
                        : line.parity == transport::Parity::even ? 'E'
                                                                 : 'O';
    context_.reset(
        modbus_new_rtu(std::get<transport::SerialAddress>(settings_.address).path.c_str(),
                       line.baud, parity, line.data_bits, line.stop_bits));
  }
  if (!context_) return failed(errno, "set up a Modbus line", {});
  modbus_set_slave(context_.get(), settings_.unit_id);
  set_timeout(timeout);
  errno = 0;
  if (modbus_connect(context_.get()) != 0) {
    // For a name that does not resolve errno says nothing useful.
    const int number = errno != 0 ? errno : EHOSTUNREACH;
    context_.reset();
    return failed(number, "connect", SteadyClock::now() - started);
  }
  return {};
}

Result<std::vector<std::uint16_t>> ModbusMaster::read(int address, int count) {
  const std::string what = registers_text("read", address, count);
  if (!context_) return failed(ENOTCONN, what, {});
  std::vector<std::uint16_t> out(static_cast<std::size_t>(count));
  const auto started = SteadyClock::now();
  const int got = modbus_read_registers(context_.get(), address, count, out.data());
  const int number = errno;
  const auto took = SteadyClock::now() - started;
  if (got != count) return failed(got < 0 ? number : EMBBADDATA, what, took);
  note(what, words_text(out), took, "");
  return out;
}

Result<void> ModbusMaster::write(int address, std::span<const std::uint16_t> registers) {
  const int count = static_cast<int>(registers.size());
  const std::string what = registers_text("write", address, count) + " = " + words_text(registers);
  if (!context_) return failed(ENOTCONN, what, {});
  const auto started = SteadyClock::now();
  const int done = count == 1
                       ? modbus_write_register(context_.get(), address, registers[0])
                       : modbus_write_registers(context_.get(), address, count, registers.data());
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
    if (context_ && !silent) wait_a_frame();
    // A late answer must not be taken for the next one: a TCP line starts over, a serial one waits
    // for silence.
    if (std::holds_alternative<transport::TcpAddress>(settings_.address)) {
      disconnect();
    } else if (context_) {
      wait_a_frame();
      modbus_flush(context_.get());
    }
    error = silent ? Error{ErrorCode::deadline_exceeded, reasons::kTimeout,
                           where + ": no answer within " + time +
                               "; another unit's address, baud rate or parity stays silent too"}
                   : Error{ErrorCode::data_loss, reasons::kBadReply,
                           where + ": " + cause + " after " + time};
  } else {
    if (what == "connect" || number == ENOTCONN) error.reason = reasons::kLinkDown;
    disconnect();
  }
  ++figures_.errors;
  note(what, "", took, error.message);
  return tl::unexpected(error);
}

// The longest Modbus frame (256 bytes of 11 bits) at the line's speed, at least 20 ms.
void ModbusMaster::wait_a_frame() const {
  const double frame_s = std::holds_alternative<transport::SerialAddress>(settings_.address)
                             ? 256.0 * 11.0 / settings_.serial.baud
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
