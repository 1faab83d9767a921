// The devices together: one time, one plant, faults; the clock; the files; the control port.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "drivers/simulated/emulators/cell/cell_outline.h"
#include "drivers/simulated/emulators/cell/device_bench.h"
#include "drivers/simulated/emulators/cell/emulator_options.h"
#include "drivers/simulated/emulators/cell/fault_desk.h"
#include "drivers/simulated/emulators/cell/sim_clock.h"
#include "drivers/simulated/emulators/interferometer_adapter/interferometer_emulator.h"
#include "drivers/simulated/emulators/pi_gcs/pi_gcs_emulator.h"
#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

namespace driftwise::simulated {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

// An emulator that answers "<seconds>" after so many seconds, to see the order of time.
class Echo : public Emulator {
 public:
  void open(Session, Link, TimeNs) override {}
  void close(Session, TimeNs) override {}
  void receive(Session session, std::string_view bytes, TimeNs now) override {
    const std::string text(bytes);
    timeline_.at(now + nanoseconds_from(std::stod(text)),
                 [this, session, text](TimeNs due) { send(session, text, due); });
  }
};

struct Bench {
  Bench()
      : bench(plant),
        a(bench.add("a", std::make_unique<Echo>())),
        b(bench.add("b", std::make_unique<Echo>())) {
    bench.set_deliver([this](std::size_t device, Session, std::string bytes) {
      said += (said.empty() ? "" : " ") + bench.id(device) + bytes;
    });
  }
  std::string until(double seconds) {
    bench.run_until(kStart + nanoseconds_from(seconds));
    return std::exchange(said, {});
  }
  TestPlant plant;
  DeviceBench bench;
  std::size_t a, b;
  std::string said;
};

TEST(DeviceBench, RunsAllDevicesInTheOrderOfTime) {
  Bench bench;
  bench.bench.receive(bench.a, 1, "3", kStart);
  bench.bench.receive(bench.b, 1, "1", kStart);
  bench.bench.receive(bench.a, 1, "2", kStart);
  EXPECT_EQ(bench.until(10), "b1 a2 a3");
  EXPECT_EQ(bench.plant.latest, kStart + 10 * kSecondNs) << "and the plant is brought along";
}

TEST(DeviceBench, WhatWasDueComesBeforeWhatArrives) {
  Bench bench;
  bench.bench.receive(bench.a, 1, "1", kStart);
  bench.bench.receive(bench.b, 1, "0", kStart + 5 * kSecondNs);
  EXPECT_EQ(bench.until(5), "a1 b0");
}

TEST(DeviceBench, AMuteDeviceNeitherHearsNorSpeaks) {
  Bench bench;
  bench.bench.receive(bench.a, 1, "1", kStart);
  bench.bench.faults(bench.a).mute_until = kStart + 3 * kSecondNs;
  bench.bench.receive(bench.a, 1, "0", kStart + kSecondNs);
  bench.bench.receive(bench.a, 1, "9", kStart + 4 * kSecondNs);
  EXPECT_EQ(bench.until(20), "a9");
}

TEST(DeviceBench, ASlowDeviceAnswersLater) {
  Bench bench;
  bench.bench.faults(bench.a).slow_ns = 2 * kSecondNs;
  bench.bench.receive(bench.a, 1, "1", kStart);
  bench.bench.receive(bench.b, 1, "2", kStart);
  EXPECT_EQ(bench.until(2.9), "b2");
  EXPECT_EQ(bench.until(3), "a1");
}

TEST(Faults, GarblingChangesBytesButNotTheEnd) {
  Faults faults;
  const std::string line = "OK ch=1 n=4096 mean_nm=12.5\n";
  const std::string damaged = faults.garbled(line);
  EXPECT_NE(damaged, line);
  EXPECT_TRUE(damaged.ends_with('\n'));
  EXPECT_EQ(Faults().garbled(line), damaged) << "the same damage every time";
}

TEST(FaultDesk, SetsFaultsAndSaysWhatItDoesNotKnow) {
  Bench bench;
  bool broken = false;
  FaultHooks hooks;
  hooks.break_beam = [&](const std::string& device, TimeNs) {
    broken = device.empty();
    return broken;
  };
  hooks.open_probe = [](int input, bool, TimeNs) { return input == 103; };
  FaultDesk desk(bench.bench, hooks);
  EXPECT_EQ(desk.answer("fault mute a 3 s", kStart), "OK");
  EXPECT_TRUE(bench.bench.faults(bench.a).mute(kStart + 2 * kSecondNs));
  EXPECT_EQ(desk.answer("fault slow b 2 s", kStart), "OK");
  EXPECT_EQ(bench.bench.faults(bench.b).slow_ns, 2 * kSecondNs);
  EXPECT_EQ(desk.answer("fault clear b", kStart), "OK");
  EXPECT_EQ(bench.bench.faults(bench.b).slow_ns, 0);
  EXPECT_EQ(desk.answer("fault garble a", kStart), "OK");
  EXPECT_EQ(bench.bench.faults(bench.a).garble_next, 1);
  EXPECT_EQ(desk.answer("fault break-beam", kStart), "OK");
  EXPECT_TRUE(broken);
  EXPECT_EQ(desk.answer("fault open-probe 103", kStart), "OK");
  EXPECT_THAT(desk.answer("fault open-probe 9", kStart), StartsWith("ERR "));
  EXPECT_THAT(desk.answer("fault mute c 3 s", kStart), HasSubstr("one of a b"));
  EXPECT_THAT(desk.answer("fault mute a", kStart), HasSubstr("<n> s"));
  EXPECT_THAT(desk.answer("fault boil a 3 s", kStart), HasSubstr("no fault 'boil'"));
  EXPECT_THAT(desk.answer("truth?", kStart), StartsWith("ERR "));
  EXPECT_THAT(desk.answer("hello", kStart), StartsWith("ERR found 'hello'"));
}

TEST(FaultDesk, LetsTimePassAndSaysWhyNot) {
  Bench bench;
  std::string why;
  double passed_s = 0;
  FaultHooks hooks;
  hooks.pass = [&](double for_s) {
    if (why.empty()) passed_s = for_s;
    return why;
  };
  FaultDesk desk(bench.bench, std::move(hooks));
  EXPECT_EQ(desk.answer("pass 32400 s", kStart), "OK");
  EXPECT_EQ(passed_s, 32400);
  for (const char* line :
       {"pass", "pass 32400", "pass -1 s", "pass nan s", "pass 700000 s", "pass 1 s more"})
    EXPECT_THAT(desk.answer(line, kStart), StartsWith("ERR expected pass <n> s")) << line;
  why = "2 connections to devices are open";
  EXPECT_EQ(desk.answer("pass 1 s", kStart), "ERR 2 connections to devices are open");
  EXPECT_EQ(passed_s, 32400);
  FaultDesk unable(bench.bench, {});
  EXPECT_EQ(unable.answer("pass 1 s", kStart), "ERR this cell cannot do that");
}

TEST(FaultDesk, HangsWeightsAndBlindsAutocollimators) {
  Bench bench;
  double hung_n = 0;
  bool jammed = false;
  FaultHooks::Spot spot = FaultHooks::Spot::good;
  FaultHooks hooks;
  hooks.hang = [&](double newton, TimeNs) { return hung_n = newton, newton <= 3.85; };
  hooks.set_jammed = [&](bool stuck, TimeNs) { jammed = stuck; };
  hooks.set_spot = [&](const std::string& device, FaultHooks::Spot now_so, TimeNs) {
    spot = now_so;
    return device == "collimator-1";
  };
  FaultDesk desk(bench.bench, hooks);
  EXPECT_EQ(desk.answer("load 2.305", kStart), "OK");
  EXPECT_EQ(hung_n, 2.305);
  EXPECT_THAT(desk.answer("load 40", kStart), HasSubstr("not so many weights"));
  EXPECT_THAT(desk.answer("load much", kStart), HasSubstr("expected load <newton>"));
  EXPECT_EQ(desk.answer("fault jam", kStart), "OK");
  EXPECT_TRUE(jammed);
  EXPECT_EQ(desk.answer("fault mend-load", kStart), "OK");
  EXPECT_FALSE(jammed);
  EXPECT_EQ(desk.answer("fault wrong-power collimator-1", kStart), "OK");
  EXPECT_EQ(spot, FaultHooks::Spot::wrong_power);
  EXPECT_EQ(desk.answer("fault mend-beam collimator-1", kStart), "OK");
  EXPECT_EQ(spot, FaultHooks::Spot::good);
  EXPECT_THAT(desk.answer("fault wrong-position axis", kStart), HasSubstr("no autocollimator"));
  FaultDesk plain(bench.bench, {});
  EXPECT_EQ(plain.answer("load 1", kStart), "ERR this cell cannot do that");
  EXPECT_EQ(plain.answer("fault jam", kStart), "ERR this cell cannot do that");
}

TEST(FaultDesk, PutsSpacersBetweenTwoRobots) {
  Bench bench;
  double height_mm = -1;
  FaultHooks hooks;
  std::array<double, 2> tilt_arcsec{};
  hooks.substrate = [&](double rx, double ry, TimeNs) {
    tilt_arcsec = {rx, ry};
    return std::abs(rx) <= 3600;
  };
  hooks.spacers = [&](double mm, TimeNs) { return height_mm = mm, mm >= 0 && mm <= 100; };
  FaultDesk desk(bench.bench, hooks);
  EXPECT_EQ(desk.answer("spacers 14 mm", kStart), "OK");
  EXPECT_EQ(height_mm, 14);
  EXPECT_THAT(desk.answer("spacers 400 mm", kStart), HasSubstr("0 to 100 mm"));
  EXPECT_THAT(desk.answer("spacers in", kStart), HasSubstr("expected spacers <h> mm"));
  EXPECT_EQ(desk.answer("substrate 540 -1296 arcsec", kStart), "OK");
  EXPECT_EQ(tilt_arcsec, (std::array<double, 2>{540, -1296}));
  EXPECT_THAT(desk.answer("substrate 4000 0 arcsec", kStart), HasSubstr("-3600 to 3600"));
  for (const char* bad : {"substrate", "substrate 540 arcsec", "substrate 5 x arcsec"})
    EXPECT_THAT(desk.answer(bad, kStart), HasSubstr("such as substrate 540 1296 arcsec"));
  EXPECT_EQ(FaultDesk(bench.bench, {}).answer("spacers 1 mm", kStart),
            "ERR this cell cannot do that");
}

struct Folder {
  Folder() {
    std::string name = (fs::temp_directory_path() / "driftwise-emulators-XXXXXX").string();
    path = ::mkdtemp(name.data());
  }
  ~Folder() { fs::remove_all(path); }
  fs::path write(const char* name, const std::string& text) const {
    std::ofstream(path / name) << text;
    return path / name;
  }
  fs::path path;
};

TEST(SimClock, RunsFromTheEpochAtItsSpeed) {
  Folder folder;
  SimClock clock(folder.path / "clock.state", kStart, 200);
  const TimeNs wall = SimClock::wall_now();
  const TimeNs cell = clock.now();
  EXPECT_GE(cell, kStart);
  EXPECT_LT(cell, kStart + 200 * 60 * kSecondNs);
  EXPECT_GE(SimClock::wall_now(), wall);
  EXPECT_EQ(clock.speed(), 200);
  EXPECT_LE(clock.wall_until(cell + 200 * kSecondNs), std::chrono::seconds(1));
  EXPECT_EQ(fs::file_size(folder.path / "clock.state"), 64u);
}

TEST(SimClock, FollowsWhoeverChangesTheSpeed) {
  Folder folder;
  const fs::path file = folder.path / "clock.state";
  SimClock clock(file, kStart, 200);
  const TimeNs target = clock.now() + 1000 * kSecondNs;
  std::fstream out(file, std::ios::in | std::ios::out | std::ios::binary);
  const double slower = 0.5;
  out.seekp(32).write(reinterpret_cast<const char*>(&slower), 8).flush();
  EXPECT_EQ(clock.speed(), 0.5);
  EXPECT_GT(clock.wall_until(target), std::chrono::seconds(1000));
}

TEST(SimClock, NeverRunsBack) {
  Folder folder;
  const fs::path file = folder.path / "clock.state";
  SimClock clock(file, kStart, 1);
  const TimeNs before = clock.now();
  std::fstream out(file, std::ios::in | std::ios::out | std::ios::binary);
  const TimeNs earlier = kStart - 1000 * kSecondNs;
  out.seekp(24).write(reinterpret_cast<const char*>(&earlier), 8).flush();
  EXPECT_EQ(clock.now(), before);
}

TEST(SimClock, IsSetForwardAndKeepsItsSpeed) {
  Folder folder;
  const fs::path file = folder.path / "clock.state";
  SimClock clock(file, kStart, 200);
  const TimeNs later = clock.now() + 9 * 3600 * kSecondNs;
  clock.set_forward(later);
  const TimeNs there = clock.now();
  EXPECT_GE(there, later);
  EXPECT_LT(there, later + 200 * 60 * kSecondNs);
  EXPECT_EQ(clock.speed(), 200);
  EXPECT_GE(SimClock(file, kStart, 1).now(), later) << "and so does the next one to open the file";
  clock.set_forward(kStart);
  EXPECT_GE(clock.now(), there) << "never back";
}

TEST(SimClock, RefusesAFileThatIsNoClock) {
  Folder folder;
  EXPECT_THROW(SimClock(folder.write("short", "DWCLOCK2"), 0, 1), SetupError);
  EXPECT_THROW(SimClock(folder.write("other", std::string(64, 'x')), 0, 1), SetupError);
  EXPECT_THROW(SimClock(folder.write("stopped", "DWCLOCK2" + std::string(56, '\0')), 0, 1),
               SetupError);
  EXPECT_THROW(SimClock("/no/such/folder/clock", 0, 1), SetupError);
}

constexpr const char* kCell = R"(# a comment that stays
[cell]
name = "test"      # and this one
listen = "127.0.0.1:50051"

[clock]
speed = 2          # faster

[[device]]
id = "axis"
kind = "pi-gcs"
address = "127.0.0.1:50000"   # here
[[device.axis]]
channel = "q1_mm"

[[device]]
address = '127.0.0.1:1394'
id = "thermo"
kind = "keithley-2701"
)";

TEST(CellOutline, ReadsDevicesAndClock) {
  Folder folder;
  const CellOutline outline = read_cell_outline(folder.write("cell.toml", kCell));
  ASSERT_EQ(outline.devices.size(), 2u);
  EXPECT_EQ(outline.devices[1].id, "thermo");
  EXPECT_EQ(outline.speed, 2);
  EXPECT_FALSE(outline.epoch.has_value());
}

TEST(CellOutline, AnInstanceKeepsEverythingElse) {
  Folder folder;
  const CellOutline outline = read_cell_outline(folder.write("cell.toml", kCell));
  const std::string text =
      instance_text(outline, {.addresses = {{"thermo", "127.0.0.1:7"}, {"axis", "127.0.0.1:8"}},
                              .epoch = "2026-11-21T08:00:00Z",
                              .clock_file = "clock.state",
                              .speed = 200});
  EXPECT_EQ(text, R"(# a comment that stays
[cell]
target_line = "127.0.0.1:0"
http = "127.0.0.1:0"
name = "test"      # and this one
listen = "127.0.0.1:0"

[clock]
epoch = "2026-11-21T08:00:00Z"
file = "clock.state"
speed = 200          # faster

[[device]]
id = "axis"
kind = "pi-gcs"
address = "127.0.0.1:8"   # here
[[device.axis]]
channel = "q1_mm"

[[device]]
address = "127.0.0.1:7"
id = "thermo"
kind = "keithley-2701"
)");
}

TEST(CellOutline, NamesFileLineAndField) {
  Folder folder;
  const auto message = [&](const std::string& text) {
    try {
      read_cell_outline(folder.write("bad.toml", text));
    } catch (const SetupError& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  EXPECT_THAT(message("[cell\n"), HasSubstr("bad.toml:1: not TOML"));
  EXPECT_THAT(message("[cell]\n"), HasSubstr("expected at least one [[device]]"));
  EXPECT_THAT(message("[[device]]\nid = 3\n"), HasSubstr("bad.toml:2: device id"));
  EXPECT_THAT(message("[[device]]\nid = \"a\"\nkind = \"x\"\n"), HasSubstr("device 'a' address"));
  EXPECT_THAT(
      message(std::string(kCell) + "[[device]]\nid = \"axis\"\nkind = \"x\"\naddress = \"\"\n"),
      HasSubstr("stands twice"));
  std::string monday = kCell;
  monday.insert(monday.find("speed"), "epoch = \"monday\"\n");
  EXPECT_THAT(message(monday), HasSubstr("bad.toml:7: clock epoch: found 'monday'"));
}

TEST(CellOutline, TimesReadBack) {
  EXPECT_EQ(parse_utc("2026-11-21T08:00:00.25Z"), 1795248000'250000000);
  EXPECT_EQ(utc_text(1795248000'250000000), "2026-11-21T08:00:00.25Z");
  EXPECT_EQ(utc_text(parse_utc("2011-07-22T00:00:00Z")), "2011-07-22T00:00:00Z");
  EXPECT_THROW(parse_utc("2011-07-22T00:00:00"), SetupError);
}

TEST(EmulatorOptions, CommandLineBeatsFileAndDeviceBeatsKind) {
  Folder folder;
  const auto plant =
      folder.write("plant.toml",
                   "[plant]\nkind = \"x\"\n[emulator.pi]\nini = false\nlatency_s = 0.5\n"
                   "[emulator.left]\nlatency_s = 0.25\n[wire]\nchop = false\n");
  std::vector<std::string> settings{"room.wander_w=0", "emulator.pi.ini=true", "wire.pause_us=7"};
  const EmulatorOptions options(plant, settings, {{"left", "pi-gcs", ""}, {"right", "pi-gcs", ""}});
  EXPECT_EQ(settings, std::vector<std::string>{"room.wander_w=0"})
      << "the plant's settings are left";
  EXPECT_TRUE(options.of("left").flag("ini"));
  EXPECT_EQ(options.of("left").number("latency_s", 0, 1), 0.25);
  EXPECT_EQ(options.of("right").number("latency_s", 0, 1), 0.5);
  EXPECT_FALSE(options.wire(1).chop);
  EXPECT_EQ(options.wire(1).pause, std::chrono::microseconds(7));
}

TEST(EmulatorOptions, NamesWhatItDoesNotKnow) {
  Folder folder;
  const auto message = [&](const std::string& text, std::vector<std::string> settings) {
    try {
      EmulatorOptions(folder.write("plant.toml", text), settings, {{"axis", "pi-gcs", ""}});
    } catch (const SetupError& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  EXPECT_THAT(message("[emulator.pi]\nfoo = 1\n", {}), HasSubstr("plant.toml:2: emulator.pi.foo"));
  EXPECT_THAT(message("[emulator.zeiss]\nfoo = 1\n", {}),
              HasSubstr("there is no emulator 'zeiss'"));
  EXPECT_THAT(message("", {"emulator.axis.foo=1"}), HasSubstr("--set emulator.axis.foo=1"));
  EXPECT_THAT(message("", {"emulator.axis"}), HasSubstr("expected emulator."));
  EXPECT_THAT(message("[emulator.pi\n", {}), HasSubstr("not TOML"));
}

TEST(EmulatorDocs, ListEverySwitch) {
  namespace fs = std::filesystem;
  const fs::path docs = DRIFTWISE_SOURCE_DIR "/docs";
  std::vector<fs::path> pages{docs / "emulators.md"};
  for (const auto& page : fs::directory_iterator(docs / "devices")) pages.push_back(page);
  std::string text;
  for (const auto& page : pages) {
    std::ifstream in(page);
    text.append(std::istreambuf_iterator<char>(in), {});
  }
  const auto check = [&](const std::vector<SwitchDescription>& all, std::string_view section) {
    for (const auto& one : all)
      EXPECT_THAT(text,
                  HasSubstr("| `" + std::string(one.name) + "` | " + std::string(one.meaning)))
          << section
          << ": put the table of driftwise-cellsim --switches --markdown into docs/emulators.md or "
             "docs/devices/<device>.md";
  };
  for (const auto& kind : emulator_kinds()) check(kind.switches(), kind.section);
  check(wire_switches(), "wire");
}

}  // namespace
}  // namespace driftwise::simulated
