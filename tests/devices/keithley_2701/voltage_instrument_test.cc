// Sensors with a voltage behind the connection of a scanner that reads thermometers too.

#include <cmath>

#include "drivers/all_devices.h"
#include "drivers/keithley_2701/platinum_resistance.h"
#include "server/core/ports/control/axis_follower.h"
#include "server/core/ports/made_device.h"
#include "tests/unit/drivers/driver_fixture.h"

namespace driftwise {
namespace {

using testing::HasSubstr;
using tests::expect;
using tests::Script;
using tests::send;

class VoltageLoop : public tests::DriverFixture {
 protected:
  VoltageLoop() { clock.run_at(60); }

  DeviceDescription thermometers() {
    auto out = device("scanner", "keithley-2701");
    out.timeout_s = 1;
    out.become<TemperatureSettings>().probes.push_back(
        {{"t01", "degC"}, 101, 1000.0, 3.9083e-3, -5.775e-7, "", "robot", 0});
    return out;
  }
  DeviceDescription gauge() {
    auto out = device("gauge", "keithley-2701");
    out.timeout_s = 1;
    out.become<LengthSettings>().channel = {"z", "mm"};
    VoltageSensor sensor;
    sensor.channel = {"z", "mm"};
    sensor.input = 201;
    sensor.slope = 0.5;
    sensor.min_v = -9;
    sensor.max_v = 9;
    out.voltages.sensors = {sensor};
    return out;
  }
  MadeDevice made(const DeviceDescription& description) {
    auto out = find_kind(drivers::all_devices(), description.kind)
                   ->make(description, {context.get_executor(), clock, {}, shared});
    EXPECT_TRUE(out) << out.error().message;
    return out ? std::move(*out) : MadeDevice();
  }
  static void append(Script& to, const Script& more) {
    to.insert(to.end(), more.begin(), more.end());
  }
  static Script selected(const std::string& list, bool first = false) {
    Script out;
    if (!first) out.push_back(expect("ROUT:SCAN:LSEL NONE\n"));
    append(out, {expect("SAMP:COUN 1\n"), expect("ROUT:SCAN " + list + "\n"),
                 expect("ROUT:SCAN:TSO IMM\n"), expect("ROUT:SCAN:LSEL INT\n"), expect("*OPC?\n"),
                 send("1\n")});
    return out;
  }
  static Script set_up_of_both() {
    Script out{expect("\x03\n"),
               expect("*IDN?\n"),
               send("KEITHLEY INSTRUMENTS INC.,MODEL 2701,1234567,A09  /A02\n"),
               expect("*RST\n"),
               expect("*CLS\n"),
               expect("*OPC?\n"),
               send("1\n"),
               expect("*OPT?\n"),
               send("7708,7700\n")};
    for (const char* command :
         {"TRAC:CLE", "INIT:CONT OFF", "FORM:ELEM READ,CHAN,TST", "TRIG:SOUR IMM", "TRIG:COUN 1",
          "TRIG:DEL 0", "ROUT:SCAN:LSEL NONE", "FUNC 'FRES',(@101)", "FRES:RANG 1000,(@101)",
          "FRES:OCOM ON,(@101)", "FRES:NPLC 5,(@101)", "FUNC 'VOLT',(@201)", "VOLT:RANG 10,(@201)",
          "VOLT:NPLC 1,(@201)"})
      out.push_back(expect(std::string(command) + "\n"));
    append(out, {expect("*OPC?\n"), send("1\n")});
    append(out, selected("(@101)", true));
    append(out, {expect("ROUT:SCAN?\n"), send("(@101)\n")});
    append(out, selected("(@201)"));
    append(out, {expect("ROUT:SCAN?\n"), send("(@201)\n"), expect("SYST:ERR?\n"),
                 send("0,\"No error\"\n")});
    return out;
  }
  std::shared_ptr<SharedByAddress> shared = std::make_shared<SharedByAddress>();
};

TEST_F(VoltageLoop, SharesTheConnectionOfTheThermometersAndSelectsItsOwnList) {
  auto script = set_up_of_both();
  append(script, {expect("READ?\n"), send("+4.000E+00,+201,+1.0\n")});
  append(script, selected("(@101)"));
  append(script, {expect("READ?\n"), send("+1.07793E+03,+101,+2.0\n")});
  append(script, {expect("READ?\n"), send("+1.07793E+03,+101,+3.0\n")});
  peer.on_connection(script);
  const auto gauge_device = made(gauge()), scanner = made(thermometers());
  const auto length = run(gauge_device.as<Instrument>()->read());
  ASSERT_TRUE(length) << length.error().message;
  EXPECT_EQ(length->device, "gauge");
  EXPECT_DOUBLE_EQ(*length->find("z_mm"), 2);
  EXPECT_DOUBLE_EQ(*length->find("gauge_201_V"), 4) << "as it was read";
  const auto temperature = run(scanner.as<Instrument>()->read());
  ASSERT_TRUE(temperature) << temperature.error().message;
  EXPECT_NEAR(*temperature->find("t01_degC"), 20, 0.02);
  EXPECT_TRUE(run(scanner.as<Instrument>()->read())) << "selected still";
  EXPECT_TRUE(peer.finished());
}

TEST_F(VoltageLoop, HasNoLengthBeyondTheRangeOfItsSensorAndCountsFromItsZero) {
  auto script = set_up_of_both();
  for (const char* volts : {"+4.0", "+5.0", "+9.5", "+9.9E37", "+9.5"})
    append(script, {expect("READ?\n"), send(std::string(volts) + ",+201,+1.0\n")});
  peer.on_connection(script);
  const auto both = std::pair(made(thermometers()), made(gauge()));
  auto& instrument = *both.second.as<Instrument>();
  EXPECT_FALSE(instrument.knows_its_zero()) << "the one of before went with the daemon";
  EXPECT_TRUE(run(instrument.zero()));
  EXPECT_TRUE(instrument.knows_its_zero());
  EXPECT_DOUBLE_EQ(*run(instrument.read())->find("z_mm"), 0.5);
  const auto beyond = run(instrument.read());
  ASSERT_TRUE(beyond) << "a state, no error";
  EXPECT_TRUE(is_missing(*beyond->find("z_mm")));
  EXPECT_DOUBLE_EQ(*beyond->find("gauge_201_V"), 9.5);
  const auto overflow = run(instrument.read());
  ASSERT_TRUE(overflow);
  EXPECT_TRUE(is_missing(*overflow->find("z_mm")));
  EXPECT_EQ(overflow->find("gauge_201_V"), nullptr);
  const auto zeroed = run(instrument.zero());
  ASSERT_FALSE(zeroed);
  EXPECT_EQ(zeroed.error().reason, "OUT_OF_RANGE");
  EXPECT_THAT(zeroed.error().message, HasSubstr("input 201 shows 9.5 V, its range is -9 .. 9 V"));
}

TEST_F(VoltageLoop, KnowsTheForceOfAMotorByTheDirectionOfItsAxis) {
  auto motor = gauge();
  motor.become<ForceSettings>().quantities = {{{"force", "N"}, 0.01}};
  motor.voltages.sensors[0].channel = {"force", "N"};
  motor.voltages.sensors[0].u = 0.01;
  motor.voltages.motor = MotorFriction{{"q1", "mm"}, 0.3, 0.02, 0.01};
  auto script = set_up_of_both();
  for (int i = 0; i < 2; ++i) append(script, {expect("READ?\n"), send("+4.0,+201,+1.0\n")});
  peer.on_connection(script);
  const auto both = std::pair(made(thermometers()), made(motor));
  auto& instrument = *both.second.as<Instrument>();
  const auto before = run(instrument.read());
  ASSERT_TRUE(before) << before.error().message;
  EXPECT_DOUBLE_EQ(*before->find("force_N"), 2);
  EXPECT_EQ(*before->find("force_dead_band_1"), 1);
  EXPECT_NEAR(*before->find("force_u_N"), std::hypot(0.01, 0.3 / std::sqrt(3.0)), 1e-12);
  auto* follower = dynamic_cast<AxisFollower*>(&both.second.device());
  ASSERT_NE(follower, nullptr);
  for (const double q_mm : {0.0, 0.5, 1.0}) follower->axis_at(q_mm);
  const auto after = run(instrument.read());
  EXPECT_DOUBLE_EQ(*after->find("force_N"), 1.7);
  EXPECT_EQ(*after->find("force_dead_band_1"), 0);
  EXPECT_EQ(run(instrument.zero()).error().reason, "NO_ZERO");
  EXPECT_TRUE(instrument.knows_its_zero()) << "zero_v";
}

TEST_F(VoltageLoop, RefusesAnInputOrAnOptionThatAnotherDeviceOfTheConnectionHas) {
  const auto scanner = made(thermometers());
  const auto* kind = find_kind(drivers::all_devices(), "keithley-2701");
  auto taken = gauge();
  taken.voltages.sensors[0].input = 101;
  const auto twice = kind->make(taken, {context.get_executor(), clock, {}, shared});
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().reason, "BAD_PROBES");
  EXPECT_THAT(twice.error().message, HasSubstr("device 'scanner' at the same address"));
  auto first = thermometers();
  first.options["mains_hz"] = "50";
  const auto other = std::make_shared<SharedByAddress>();
  const auto kept = kind->make(first, {context.get_executor(), clock, {}, other});
  auto differs = gauge();
  differs.options["mains_hz"] = "60";
  const auto refused = kind->make(differs, {context.get_executor(), clock, {}, other});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "BAD_OPTION");
  EXPECT_THAT(refused.error().message, HasSubstr("it is one connection"));
}

}  // namespace
}  // namespace driftwise
