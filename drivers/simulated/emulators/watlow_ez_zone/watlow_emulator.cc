#include "drivers/simulated/emulators/watlow_ez_zone/watlow_emulator.h"

#include <vector>

#include "drivers/simulated/emulators/emulator_kind.h"

namespace driftwise::simulated {
namespace {

constexpr std::size_t kMbapSize = 7;
constexpr std::size_t kRtuLongest = 256;
constexpr unsigned kReadHolding = 3, kWriteOne = 6, kWriteMany = 16;

unsigned byte_at(std::string_view bytes, std::size_t i) {
  return static_cast<unsigned char>(bytes[i]);
}
unsigned word_at(std::string_view bytes, std::size_t i) {
  return byte_at(bytes, i) << 8 | byte_at(bytes, i + 1);
}
void add_word(std::string& out, unsigned word) {
  out += static_cast<char>(word >> 8 & 0xFF);
  out += static_cast<char>(word & 0xFF);
}

std::string exception(unsigned function, ModbusException code) {
  std::string out(1, static_cast<char>(function | 0x80));
  out += static_cast<char>(code);
  return out;
}

// Length of an RTU request with address and CRC; 0: more bytes are needed to tell, nullopt: unknown
// function.
std::optional<std::size_t> rtu_length(std::string_view bytes) {
  if (bytes.size() < 2) return 0;
  switch (byte_at(bytes, 1)) {
    case kReadHolding:
    case kWriteOne:
      return 8;
    case kWriteMany:
      return bytes.size() < 7 ? 0 : 9 + byte_at(bytes, 6);
    default:
      return std::nullopt;
  }
}

}  // namespace

std::uint16_t modbus_crc(std::string_view bytes) {
  unsigned crc = 0xFFFF;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    crc ^= byte_at(bytes, i);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? crc >> 1 ^ 0xA001 : crc >> 1;
  }
  return static_cast<std::uint16_t>(crc);
}

WatlowEmulator::WatlowEmulator(PlantStabilisers& plant, const Switches& s, int first,
                               TimeNs power_on)
    : registers_(plant, s, first, power_on),
      unit_(s.integer("unit_id", 1, 247)),
      latency_(nanoseconds_from(s.number("latency_s", 0, 10))),
      gap_(nanoseconds_from(s.number("rtu_gap_s", 1e-3, 10))) {}

void WatlowEmulator::open(Session session, Link link, TimeNs) {
  clients_.insert_or_assign(session, Client{link, {}, {}});
}

void WatlowEmulator::close(Session session, TimeNs) {
  if (const auto found = clients_.find(session); found != clients_.end()) {
    timeline_.cancel(found->second.gap);
    clients_.erase(found);
  }
}

void WatlowEmulator::receive(Session session, std::string_view bytes, TimeNs now) {
  const auto found = clients_.find(session);
  if (found == clients_.end()) return;
  Client& client = found->second;
  client.input += bytes;
  if (client.link == Link::tcp) {
    tcp_frames(session, client, now);
    return;
  }
  timeline_.cancel(client.gap);
  rtu_frames(session, client, false, now);
  if (client.input.empty()) return;
  client.gap = timeline_.at(now + gap_, [this, session](TimeNs due) {
    const auto still = clients_.find(session);
    if (still != clients_.end()) rtu_frames(session, still->second, true, due);
  });
}

void WatlowEmulator::tcp_frames(Session session, Client& client, TimeNs now) {
  std::string_view rest = client.input;
  while (rest.size() >= kMbapSize) {
    const std::size_t length = word_at(rest, 4);  // unit id and PDU
    if (length < 2 || length > 254) {
      rest = {};
      break;
    }
    if (rest.size() < 6 + length) break;
    const std::string_view frame = rest.substr(0, 6 + length);
    rest.remove_prefix(6 + length);
    if (word_at(frame, 2) != 0 || static_cast<int>(byte_at(frame, 6)) != unit_) continue;
    const std::string pdu = answer(frame.substr(kMbapSize), now);
    std::string out(frame.substr(0, 4));
    add_word(out, static_cast<unsigned>(pdu.size() + 1));
    out += frame[6];
    reply(session, out + pdu, now);
  }
  client.input.erase(0, client.input.size() - rest.size());
}

void WatlowEmulator::rtu_frames(Session session, Client& client, bool silence, TimeNs now) {
  const auto serve = [&](std::string_view frame) {
    if (frame.size() < 4) return;
    const std::string_view body = frame.substr(0, frame.size() - 2);
    const unsigned crc = byte_at(frame, frame.size() - 2) | byte_at(frame, frame.size() - 1) << 8;
    if (crc != modbus_crc(body) || static_cast<int>(byte_at(body, 0)) != unit_) return;
    std::string out = body[0] + answer(body.substr(1), now);
    const unsigned own = modbus_crc(out);
    out += static_cast<char>(own & 0xFF);
    out += static_cast<char>(own >> 8);
    reply(session, std::move(out), now);
  };
  while (!client.input.empty()) {
    const auto length = rtu_length(client.input);
    const bool whole = length && *length > 0 && client.input.size() >= *length;
    if (!whole && !silence && client.input.size() < kRtuLongest) return;
    const std::size_t taken = whole ? *length : client.input.size();
    serve(std::string_view(client.input).substr(0, taken));
    client.input.erase(0, taken);
  }
}

std::string WatlowEmulator::answer(std::string_view pdu, TimeNs now) {
  const unsigned function = byte_at(pdu, 0);
  if (function != kReadHolding && function != kWriteOne && function != kWriteMany)
    return exception(function, ModbusException::function);
  if (pdu.size() < 5) return exception(function, ModbusException::value);
  const int address = static_cast<int>(word_at(pdu, 1));
  const unsigned count = word_at(pdu, 3);
  if (function == kReadHolding) {
    if (pdu.size() != 5 || count == 0 || count > 125)
      return exception(function, ModbusException::value);
    std::vector<std::uint16_t> words(count);
    const auto refused = registers_.read(address, words, now);
    if (refused != ModbusException::none) return exception(function, refused);
    std::string out{static_cast<char>(function), static_cast<char>(2 * count)};
    for (const auto word : words) add_word(out, word);
    return out;
  }
  std::vector<std::uint16_t> words;
  if (function == kWriteOne) {
    if (pdu.size() != 5) return exception(function, ModbusException::value);
    words.push_back(static_cast<std::uint16_t>(count));
  } else {
    if (count == 0 || count > 123 || pdu.size() != 6 + 2 * count || byte_at(pdu, 5) != 2 * count)
      return exception(function, ModbusException::value);
    for (unsigned i = 0; i < count; ++i)
      words.push_back(static_cast<std::uint16_t>(word_at(pdu, 6 + 2 * i)));
  }
  const auto refused = registers_.write(address, words, now);
  if (refused != ModbusException::none) return exception(function, refused);
  return std::string(pdu.substr(0, 5));
}

void WatlowEmulator::reply(Session session, std::string frame, TimeNs now) {
  timeline_.at(now + latency_, [this, session, bytes = std::move(frame)](TimeNs due) {
    if (clients_.contains(session)) send(session, bytes, due);
  });
}

namespace emulator_kind {

extern const EmulatorKind watlow_ez_zone;
const EmulatorKind watlow_ez_zone{
    .kind = "watlow-ez-zone",
    .section = "watlow",
    .quantity = Quantity::stabiliser,
    .switches = WatlowRegisters::switches,
    .serial_switch = "rtu",
    .make = [](Plant& plant, const Switches& switches, PlantPlaces& places,
               TimeNs now) -> std::unique_ptr<Emulator> {
      return std::make_unique<WatlowEmulator>(
          plant, switches, places.take(Quantity::stabiliser, switches.integer("zones", 1, 12)),
          now);
    }};

}  // namespace emulator_kind

}  // namespace driftwise::simulated
