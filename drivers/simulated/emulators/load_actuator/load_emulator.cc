#include "drivers/simulated/emulators/load_actuator/load_emulator.h"

#include "drivers/simulated/emulators/emulator_kind.h"
#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {
namespace {

constexpr std::size_t kLoadLineLimit = 128;

std::string load_refusal(int code, const std::string& text) {
  return "ERR " + std::to_string(code) + " " + text;
}

}  // namespace

const std::vector<SwitchDescription>& LoadEmulator::switches() {
  static const std::vector<SwitchDescription> kAll{
      {"identity", "Driftwise weights 0001", "own", "maker, model and serial of IDN?"},
      {"busy_is_error", "true", "own", "LOAD while weights move: ERR 3; false: the newer one wins"},
      {"latency_s", "0.005", "own", "from a request to its reply"},
      {"max_clients", "4", "own", "TCP connections at a time; one more is closed at once"},
  };
  return kAll;
}

LoadEmulator::LoadEmulator(PlantLoad& plant, const Switches& s)
    : plant_(plant),
      identity_(s.text("identity")),
      latency_(nanoseconds_from(s.number("latency_s", 0, 10))),
      busy_is_error_(s.flag("busy_is_error")) {
  if (!plant.has_load()) throw SetupError("[emulator.load]: this plant has no load");
}

void LoadEmulator::open(Session session, Link, TimeNs) {
  input_.insert_or_assign(session, LineBuffer('\n', kLoadLineLimit));
}

void LoadEmulator::close(Session session, TimeNs) { input_.erase(session); }

void LoadEmulator::receive(Session session, std::string_view bytes, TimeNs now) {
  const auto found = input_.find(session);
  if (found == input_.end()) return;
  for (const char c : bytes) {
    auto line = found->second.push(c);
    if (!line) continue;
    if (line->text.ends_with('\r')) line->text.pop_back();
    if (trim(line->text).empty() && !line->overrun) continue;
    timeline_.at(now + latency_, [this, session, text = answer(*line, now) + "\n"](TimeNs due) {
      if (input_.contains(session)) send(session, text, due);
    });
  }
}

std::string LoadEmulator::answer(const LineBuffer::Line& line, TimeNs now) {
  const auto words = split_blanks(line.text);
  const std::string name = words.empty() || line.overrun ? "" : upper(words[0]);
  if (name == "IDN?" && words.size() == 1) return "OK " + identity_;
  const LoadState state = plant_.load(now);
  if (name == "LOAD?" && words.size() == 1)
    return "OK " + shortest(state.newton) + (state.resting ? " 1" : " 0");
  const auto newton =
      name == "LOAD" && words.size() == 2 ? parse_number(words[1]) : std::optional<double>();
  if (!newton) return load_refusal(1, "expected IDN?, LOAD? or LOAD <newton>");
  if (*newton < 0 || *newton > state.max_newton)
    return load_refusal(2, "no such load: 0 to " + shortest(state.max_newton) + " N");
  if (state.jammed) return load_refusal(4, "jammed at " + shortest(state.newton) + " N");
  if (!state.resting && busy_is_error_) return load_refusal(3, "weights are moving");
  plant_.set_load(*newton, now);
  return "OK";
}

namespace emulator_kind {

extern const EmulatorKind load_actuator;
const EmulatorKind load_actuator{.kind = "load-actuator",
                                 .section = "load",
                                 .quantity = Quantity::load,
                                 .switches = LoadEmulator::switches,
                                 .serial_switch = "",
                                 .make = [](Plant& plant, const Switches& switches, PlantPlaces&,
                                            TimeNs) -> std::unique_ptr<Emulator> {
                                   return std::make_unique<LoadEmulator>(plant, switches);
                                 }};

}  // namespace emulator_kind

}  // namespace driftwise::simulated
