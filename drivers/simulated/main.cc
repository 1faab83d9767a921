// driftwise-cellsim: a simulated measuring cell that speaks its instruments' real wire protocols on
// loopback ports.

#include <signal.h>
#include <sys/prctl.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/asio/signal_set.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "drivers/simulated/emulators/cell/cell_server.h"
#include "drivers/simulated/emulators/cell/lying_plant.h"
#include "drivers/simulated/emulators/text.h"
#include "drivers/simulated/plant/file/hide.h"
#include "drivers/simulated/plant/file/make_plant.h"

namespace driftwise::simulated {
namespace {

namespace fs = std::filesystem;
constexpr int kExitUsage = 2, kExitBadInput = 3;

constexpr const char* kExamples = R"(Examples:
  # the demo's cell, 200 times as fast as life, in a folder of its own
  driftwise-cellsim --plant deploy/cells/linear-axis/plant.toml \
      --cell deploy/cells/linear-axis/cell.toml --instantiate /tmp/cell --speed 200
  driftwised --cell /tmp/cell/cell.toml

  # another controller model, no chopping of replies, quiet room
  driftwise-cellsim ... --set emulator.pi.ini=false --set wire.chop=false --set room.wander_w=0

  # hide something in it, and read the answer when the finding stands
  driftwise-cellsim ... --hide backlash:q1=80nm,thermal_lag:t07=1800s
  driftwise-cellsim ... --hide random --seed 20261122 --sealed /tmp/answer.json

  # every switch of every device
  driftwise-cellsim --switches

A line READY {"axis":"127.0.0.1:40123",...} on standard output says that it serves. SIGTERM or SIGINT ends it.
Without --instantiate it serves at the addresses that stand in the cell file, at the cell file's own speed.
What goes wrong on purpose is told to the port "control" (a line "help" lists it); see docs/emulators.md.)";

struct Arguments {
  fs::path plant, cell, instance;
  double speed = 0;  // 0: the cell file's
  std::uint64_t seed = 1;
  std::vector<std::string> settings;
  std::string hide;  // causes, or "random"
  fs::path sealed;   // where the answer goes
};

void print_switches(bool markdown) {
  const auto print = [markdown](std::string_view section,
                                const std::vector<SwitchDescription>& all) {
    if (markdown)
      std::cout << "\n### `[" << section
                << "]`\n\n| switch | meaning | default | tag |\n|---|---|---|---|\n";
    for (const auto& one : all) {
      if (markdown)
        std::cout << "| `" << one.name << "` | " << one.meaning << " | `" << one.default_value
                  << "` | " << one.tag << " |\n";
      else
        std::cout << section << "." << one.name << " = " << one.default_value << "  (" << one.tag
                  << ") " << one.meaning << "\n";
    }
  };
  for (const auto& kind : emulator_kinds())
    print("emulator." + std::string(kind.section), kind.switches());
  print("wire", wire_switches());
}

std::string truth_json(CellPlant& plant, TimeNs now) {
  nlohmann::ordered_json json{{"time_ns", now}};
  const auto columns = plant.truth_columns();
  const auto values = plant.truth_values(now);
  for (std::size_t i = 0; i < columns.size(); ++i) json[columns[i]] = values[i];
  return json.dump();
}

// Place of a device among those of its quantity, in the order of the cell file: as the server
// counts them.
std::optional<int> place_of(const CellOutline& outline, Quantity quantity, const std::string& id) {
  int place = 0;
  for (const auto& device : outline.devices) {
    const EmulatorKind* kind = find_emulator_kind(device.kind);
    if (kind == nullptr || kind->quantity != quantity) continue;
    if (device.id == id || id.empty()) return place;
    ++place;
  }
  return std::nullopt;
}

std::string microscope_json(const TwoRobotsPlant& plant, int origin) {
  if (origin < 1 || static_cast<std::size_t>(origin) > plant.craters().size()) return "";
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const MicroscopeRow& row : plant.microscope(origin))
    rows.push_back({{"id", row.id},
                    {"x_um", row.x_um},
                    {"y_um", row.y_um},
                    {"pixel_nm", row.pixel_nm},
                    {"marking_px", row.marking_px},
                    {"pictures_joined", row.pictures_joined},
                    {"diagonal_um", row.diagonal_um}});
  return rows.dump();
}

void add_two_robots_hooks(FaultHooks& hooks, TwoRobotsPlant& plant) {
  hooks.knock = [&plant](double amplitude_nm, TimeNs now) { plant.knock(amplitude_nm, now); };
  hooks.spacers = [&plant](double height_mm, TimeNs now) {
    constexpr double kHighest_mm = 100;
    if (!(height_mm >= 0 && height_mm <= kHighest_mm)) return false;
    plant.set_spacers_mm(height_mm, now);
    return true;
  };
  hooks.substrate = [&plant](double rx_arcsec, double ry_arcsec, TimeNs now) {
    constexpr double kSteepest_arcsec = 3600;
    if (!(std::abs(rx_arcsec) <= kSteepest_arcsec && std::abs(ry_arcsec) <= kSteepest_arcsec))
      return false;
    plant.set_substrate_arcsec(rx_arcsec, ry_arcsec, now);
    return true;
  };
  hooks.microscope_json = [&plant](int origin) { return microscope_json(plant, origin); };
}

void add_micro_nano_hooks(FaultHooks& hooks, MicroNanoPlant& plant, const CellOutline& outline) {
  hooks.set_spot = [&plant, outline](const std::string& device, FaultHooks::Spot spot, TimeNs now) {
    using Fault = MicroNanoPlant::CollimatorFault;
    const auto place = place_of(outline, Quantity::angle, device);
    if (!place) return false;
    plant.set_collimator_fault(*place,
                               spot == FaultHooks::Spot::wrong_power      ? Fault::wrong_power
                               : spot == FaultHooks::Spot::wrong_position ? Fault::wrong_position
                                                                          : Fault::none,
                               now);
    return true;
  };
  hooks.set_jammed = [&plant](bool jammed, TimeNs now) { plant.set_load_jammed(jammed, now); };
  hooks.hang = [&plant](double newton, TimeNs now) {
    if (newton < 0 || newton > plant.load(now).max_newton) return false;
    plant.set_load(newton, now);
    return true;
  };
}

// The first channel of each kind of device.
bool tell_lie(LyingPlant& plant, const CellOutline& outline, const std::string& device,
              const std::string& form, double amount) {
  if (device.empty()) {
    plant.tell_the_truth();
    return true;
  }
  constexpr int kFirstInput = 101;
  const auto found = std::ranges::find(outline.devices, device, &DeviceOutline::id);
  if (found == outline.devices.end()) return false;
  const EmulatorKind* kind = find_emulator_kind(found->kind);
  const auto place = kind ? place_of(outline, kind->quantity, device) : std::nullopt;
  if (!place) return false;
  const auto how = form == "jump"    ? Lie::Form::jump
                   : form == "scale" ? Lie::Form::scale
                   : form == "value" ? Lie::Form::value
                                     : Lie::Form::constant;
  const bool is_probe = kind->quantity == Quantity::probe;
  plant.tell({kind->quantity, is_probe ? kFirstInput : *place, how, amount});
  return true;
}

FaultHooks hooks_of(CellPlant& plant, LyingPlant& lying, const CellOutline& outline, TimeNs epoch) {
  FaultHooks hooks;
  hooks.lie = [&lying, outline](const std::string& device, const std::string& form, double amount) {
    return tell_lie(lying, outline, device, form, amount);
  };
  if (auto* micro_nano = dynamic_cast<MicroNanoPlant*>(&plant))
    add_micro_nano_hooks(hooks, *micro_nano, outline);
  if (auto* two = dynamic_cast<TwoRobotsPlant*>(&plant)) add_two_robots_hooks(hooks, *two);
  // Adapters of one channel: the n-th is the plant's n-th.
  hooks.break_beam = [&plant, outline](const std::string& device, TimeNs now) {
    const auto place = place_of(outline, Quantity::length, device);
    if (place) plant.break_beam(now, *place);
    return place.has_value();
  };
  hooks.open_probe = [&plant](int input, bool open, TimeNs now) {
    if (!plant.has_probe(input) && !plant.has_voltage(input)) return false;
    plant.set_probe_open(input, open, now);
    return true;
  };
  hooks.input_volt = [&plant](int input, std::optional<double> volts, TimeNs now) {
    if (!plant.has_voltage(input)) return false;
    plant.set_input_volt(input, volts, now);
    return true;
  };
  hooks.disturb = [&plant, epoch](TimeNs from, TimeNs until, double amplitude_nm) {
    const double from_s = seconds_between(epoch, from), until_s = seconds_between(epoch, until);
    // 2.7 Hz and its like: neither averaged away within one reading nor equal from one to the next.
    plant.add_disturbance(
        DisturbancePlace::interferometer_nm, [=](const DisturbanceContext& context) {
          if (context.time_s < from_s || context.time_s >= until_s) return 0.0;
          const double t = context.time_s - from_s;
          return amplitude_nm * (std::sin(2.3 * t) + 0.7 * std::sin(0.83 * t * t));
        });
  };
  hooks.open_box = [&plant](double for_s, TimeNs now) { return plant.open_box(for_s, now); };
  hooks.truth_json = [&plant](TimeNs now) { return truth_json(plant, now); };
  return hooks;
}

void write_file(const fs::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out << text << std::flush;
  if (!out) throw SetupError(file.string() + ": cannot be written");
}

int run(Arguments arguments) {
  const CellOutline outline = read_cell_outline(arguments.cell);
  const EmulatorOptions options(arguments.plant, arguments.settings, outline.devices);
  const bool instance = !arguments.instance.empty();
  if (!instance && arguments.speed > 0 && arguments.speed != outline.speed)
    throw SetupError("--speed " + shortest(arguments.speed) +
                     " without --instantiate: " + arguments.cell.string() + " says " +
                     shortest(outline.speed) + ", and a daemon would believe it");
  const double speed = arguments.speed > 0 ? arguments.speed : outline.speed;

  // An instance is new: what an earlier one left in the folder is not its past. Without one a clock
  // that is there goes on, so that a daemon which is already running keeps its time.
  const fs::path folder =
      instance ? arguments.instance : fs::absolute(arguments.cell).parent_path();
  const std::string clock_name = !outline.clock_file.empty() ? outline.clock_file : "clock.state";
  const bool shared = instance || speed != 1 || !outline.clock_file.empty();
  TimeNs epoch = outline.epoch.value_or(SimClock::wall_now());
  if (instance) {
    fs::create_directories(folder);
    fs::remove(folder / clock_name);
    fs::remove(folder / "truth.csv");
  } else if (shared && fs::exists(folder / clock_name)) {
    epoch = SimClock(folder / clock_name, epoch, speed).now();
  } else if (!shared) {
    epoch = SimClock::wall_now();
  }

  // The controller's delay before a motion is the emulator's (emulator.pi.start_delay_s): not
  // twice.
  std::vector<std::string> settings{"axis.start_delay_s=0"};
  settings.insert(settings.end(), arguments.settings.begin(), arguments.settings.end());
  if (!arguments.hide.empty()) {
    const auto causes =
        hide(arguments.hide, read_plant_file(arguments.plant, settings), arguments.seed);
    for (const auto& cause : causes) settings.push_back(cause.override);
    if (!arguments.sealed.empty())
      write_file(arguments.sealed, hidden_answer_json(causes, arguments.seed));
  }
  const auto plant = make_any_plant(
      arguments.plant, {.seed = arguments.seed, .overrides = settings, .epoch_ns = epoch});
  if (instance)
    plant->attach_truth_log(
        std::make_unique<TruthLog>(folder / "truth.csv", plant->truth_columns()));
  // The clock starts last: at high speed the plant's warm-up would be minutes of cell time.
  const auto clock = shared ? std::make_unique<SimClock>(folder / clock_name, epoch, speed)
                            : std::make_unique<SimClock>();

  boost::asio::io_context io(1);
  LyingPlant lying(*plant);
  CellServer server(io, lying, *clock, outline, options, hooks_of(*plant, lying, outline, epoch),
                    {.free_ports = instance, .seed = arguments.seed});
  if (instance) {
    CellChanges changes{.addresses = server.addresses(),
                        .epoch = utc_text(epoch),
                        .clock_file = clock_name,
                        .speed = speed};
    write_file(arguments.instance / "cell.toml", instance_text(outline, changes));
  }
  boost::asio::signal_set signals(io, SIGTERM, SIGINT);
  signals.async_wait([&](boost::system::error_code, int) {
    server.stop();
    io.stop();
  });
  server.start();
  // Said last: whoever reads it may end us at once.
  nlohmann::ordered_json ready;
  for (const auto& [id, address] : server.addresses()) ready[id] = address;
  std::cout << "READY " << ready.dump() << std::endl;
  io.run();
  return 0;
}

}  // namespace
}  // namespace driftwise::simulated

int main(int argc, char** argv) {
  using namespace driftwise::simulated;
  Arguments arguments;
  bool switches = false, markdown = false;
  CLI::App app{
      "A simulated measuring cell: robot, controller, instruments and room in one process, on "
      "loopback ports."};
  app.footer(kExamples);
  app.add_option("--plant", arguments.plant, "plant file: the physics, and [emulator.*] switches");
  app.add_option("--cell", arguments.cell, "cell file: which devices there are");
  app.add_option(
      "--instantiate", arguments.instance,
      "folder for a cell of its own: cell.toml with the real addresses, clock.state, truth.csv");
  app.add_option("--speed", arguments.speed, "cell seconds per second (default: the cell file's)")
      ->check(CLI::Range(1e-3, 1e5));
  app.add_option("--seed", arguments.seed, "of weather, noise and chopping (default 1)");
  app.add_option("--set", arguments.settings,
                 "section.key=value over the plant file; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--hide", arguments.hide,
                 "causes to hide in the plant: backlash:q1=80nm,thermal_lag:t07=1800s, or random");
  app.add_option("--sealed", arguments.sealed,
                 "with --hide: file for the answer; it is written before the cell serves")
      ->needs("--hide");
  app.add_flag("--switches", switches, "list the devices' switches with default and meaning");
  app.add_flag("--markdown", markdown, "with --switches: as the tables of docs/emulators.md");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kExitUsage;
  }
  if (switches) {
    print_switches(markdown);
    return 0;
  }
  if (arguments.plant.empty() || arguments.cell.empty()) {
    std::cerr << "driftwise-cellsim: --plant and --cell are needed; --help shows examples\n";
    return kExitUsage;
  }
  // Wake-ups to the microsecond: at speed 200 the usual 50 us are 10 ms of cell time.
  ::prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0);
  ::signal(SIGPIPE, SIG_IGN);
  try {
    return run(std::move(arguments));
  } catch (const std::exception& error) {
    std::cerr << "driftwise-cellsim: " << error.what() << "\n";
    return kExitBadInput;
  }
}
