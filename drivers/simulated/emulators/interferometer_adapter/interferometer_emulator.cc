#include "drivers/simulated/emulators/interferometer_adapter/interferometer_emulator.h"

#include <algorithm>
#include <cstdio>

#include "drivers/simulated/emulators/emulator_kind.h"
#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {
namespace {

constexpr std::size_t kAdapterLineLimit = 256;
constexpr std::size_t kWaitingLimit = 64;

// Unix seconds with nine decimals; not through a double, which would lose the last digits.
std::string unix_text(TimeNs time) {
  char buffer[48];
  const TimeNs whole = time / kSecondNs - (time % kSecondNs < 0 ? 1 : 0);
  std::snprintf(buffer, sizeof buffer, "%lld.%09lld", static_cast<long long>(whole),
                static_cast<long long>(time - whole * kSecondNs));
  return buffer;
}

std::string refusal(int code, std::string_view text) {
  return "ERR " + std::to_string(code) + " " + std::string(text) + "\n";
}

}  // namespace

const std::vector<SwitchDescription>& InterferometerEmulator::switches() {
  static const std::vector<SwitchDescription> kAll{
      {"identity", "SIOS SP-2000 SP2000-0471", "own", "maker, model and serial of IDN?"},
      {"channels", "1", "own", "channels of this adapter; further ones are the plant's next"},
      {"samples", "4096", "own", "AVG after power-on: 2048 or 4096 or 8192 or 16384"},
      {"latency_s", "0.001", "own", "from a request (or the end of a measurement) to its reply"},
      {"unstable_is_error", "true", "own",
       "MEAS? with an unstable laser answers ERR 6; false: OK without status bit 0x0010"},
      {"max_clients", "8", "own", "TCP connections at a time; one more is closed at once"},
  };
  return kAll;
}

InterferometerEmulator::InterferometerEmulator(PlantLengths& plant, const Switches& s, int first)
    : plant_(plant),
      first_(first),
      channels_(s.integer("channels", 1, 16)),
      samples_(s.integer("samples", 2048, 16384)),
      identity_(s.text("identity")),
      latency_(nanoseconds_from(s.number("latency_s", 0, 10))),
      unstable_is_error_(s.flag("unstable_is_error")) {
  s.choice("samples", {"2048", "4096", "8192", "16384"});
  if (first < 0 || first + channels_ > plant.interferometer_count())
    throw SetupError("[emulator.interferometer] channels: asked for the plant's interferometers " +
                     std::to_string(first + 1) + " to " + std::to_string(first + channels_) +
                     ", it has " + std::to_string(plant.interferometer_count()));
}

void InterferometerEmulator::open(Session session, Link, TimeNs) {
  clients_.insert_or_assign(session,
                            Client{LineBuffer('\n', kAdapterLineLimit), {}, false, ++last_serial_});
}

void InterferometerEmulator::close(Session session, TimeNs) { clients_.erase(session); }

void InterferometerEmulator::receive(Session session, std::string_view bytes, TimeNs now) {
  const auto found = clients_.find(session);
  if (found == clients_.end()) return;
  Client& client = found->second;
  for (const char c : bytes) {
    auto done = client.input.push(c);
    if (!done) continue;
    if (client.waiting.size() >= kWaitingLimit) done->overrun = true, done->text.clear();
    if (client.waiting.size() < 2 * kWaitingLimit) client.waiting.push_back(std::move(*done));
  }
  start_next(session, client, now);
}

void InterferometerEmulator::start_next(Session session, Client& client, TimeNs now) {
  while (!client.busy && !client.waiting.empty()) {
    LineBuffer::Line line = std::move(client.waiting.front());
    client.waiting.pop_front();
    if (line.text.ends_with('\r')) line.text.pop_back();
    if (trim(line.text).empty() && !line.overrun) continue;
    client.busy = true;
    const auto words = split_blanks(line.text);
    if (!line.overrun && words.size() == 2 && upper(words[0]) == "MEAS?") {
      if (const auto wanted = channel(words[1])) {
        measure(session, *wanted, now);
        return;
      }
    }
    timeline_.at(now + latency_, [this, session, serial = client.serial, reply = answer(line, now)](
                                     TimeNs due) { finish(session, serial, reply, due); });
  }
}

std::string InterferometerEmulator::answer(const LineBuffer::Line& line, TimeNs now) {
  if (line.overrun) return refusal(5, "request too long or too many waiting");
  const auto words = split_blanks(line.text);
  const std::string name = upper(words[0]);
  const auto argument = [&](std::size_t i) { return parse_integer(words[i]); };
  if (name == "IDN?" && words.size() == 1)
    return "OK " + identity_ + " ch=" + std::to_string(channels_) + "\n";
  if (name == "AVG" && words.size() == 2) {
    const auto n = argument(1);
    if (!n || (*n != 2048 && *n != 4096 && *n != 8192 && *n != 16384))
      return refusal(1, "AVG takes 2048, 4096, 8192 or 16384");
    samples_ = *n;
    return "OK\n";
  }
  if (name == "ZERO" && words.size() == 2) {
    const auto mask = argument(1);
    if (!mask || *mask < 1 || *mask >= 1 << 15) return refusal(1, "ZERO takes a mask of channels");
    // Bits of channels that are not there are ignored, as the maker's library does with its masks.
    for (int i = 0; i < channels_; ++i) {
      if ((*mask >> i & 1) != 0) plant_.zero_length(first_ + i, now);
    }
    return "OK\n";
  }
  if (name == "DEADPATH" && words.size() == 3) {
    const auto wanted = channel(words[1]);
    const auto mm = parse_number(words[2]);
    if (!mm || *mm < 0 || *mm > 1e5) return refusal(1, "DEADPATH takes a channel and millimetres");
    if (!wanted) return refusal(2, "no such channel");
    plant_.set_dead_path_mm(first_ + *wanted - 1, *mm);
    return "OK\n";
  }
  if (name == "MEAS?" && words.size() == 2 && argument(1)) return refusal(2, "no such channel");
  return refusal(1, "syntax");
}

void InterferometerEmulator::measure(Session session, int wanted, TimeNs start) {
  const int samples = samples_;
  const TimeNs end = start + nanoseconds_from(samples / plant_.sample_rate_hz());
  const auto serial = clients_.at(session).serial;
  timeline_.at(end, [this, session, serial, wanted, start, samples](TimeNs now) {
    const std::string reply = measured(wanted, start, samples, now);
    timeline_.at(now + latency_, [this, session, serial, reply](TimeNs due) {
      finish(session, serial, reply, due);
    });
  });
}

std::string InterferometerEmulator::measured(int wanted, TimeNs start, int samples, TimeNs now) {
  const LengthReading reading = plant_.measure_length(first_ + wanted - 1, start, samples);
  if (reading.beam_broken) return refusal(3, "beam break since the last zero");
  if (!reading.laser_stable && unstable_is_error_) return refusal(6, "laser unstable");
  return "OK ch=" + std::to_string(wanted) + " n=" + std::to_string(samples) +
         " mean_nm=" + fixed(reading.mean_nm, 4) + " std_nm=" + fixed(reading.std_nm, 4) +
         " t_air_C=" + fixed(reading.air_degc, 5) + " t_age_s=" + fixed(reading.air_age_s, 3) +
         " level_pct=" + fixed(reading.level_pct, 1) +
         " status=" + (reading.laser_stable ? "0x0010" : "0x0020") +
         " t0=" + unix_text(start + clock_ahead_) + " t1=" + unix_text(now + clock_ahead_) + "\n";
}

void InterferometerEmulator::finish(Session session, std::uint64_t serial, const std::string& reply,
                                    TimeNs now) {
  const auto found = clients_.find(session);
  if (found == clients_.end() || found->second.serial != serial) return;
  found->second.busy = false;
  send(session, reply, now);
  start_next(session, found->second, now);
}

std::optional<int> InterferometerEmulator::channel(std::string_view text) const {
  const auto number = parse_integer(text);
  if (!number || *number < 1 || *number > channels_) return std::nullopt;
  return number;
}

namespace emulator_kind {

extern const EmulatorKind interferometer_adapter;
const EmulatorKind interferometer_adapter{
    .kind = "interferometer-adapter",
    .section = "interferometer",
    .quantity = Quantity::length,
    .switches = InterferometerEmulator::switches,
    .serial_switch = "",
    .make = [](Plant& plant, const Switches& switches, PlantPlaces& places,
               TimeNs) -> std::unique_ptr<Emulator> {
      return std::make_unique<InterferometerEmulator>(
          plant, switches, places.take(Quantity::length, switches.integer("channels", 1, 16)));
    }};

}  // namespace emulator_kind

}  // namespace driftwise::simulated
