// The Watlow driver against an independent Modbus server (python3-pymodbus), over TCP and over a
// serial pair.

#include <gmock/gmock.h>

#include <boost/asio/ip/tcp.hpp>

#include "drivers/watlow_ez_zone/modbus_master.h"
#include "drivers/watlow_ez_zone/registers.h"
#include "drivers/watlow_ez_zone/watlow_ez_zone.h"
#include "server/core/ports/control/tunable_loop.h"
#include "tests/support/manual_clock.h"
#include "tests/support/process.h"
#include "tests/support/run_awaitable.h"

namespace driftwise {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

bool peer_can_run() {
  return tests::run_process({"/usr/bin/python3", "-c", "import pymodbus, serial_asyncio"}, 20s)
                 .code == 0 &&
         tests::run_process({"/usr/bin/socat", "-V"}, 5s).code == 0;
}

int free_port() {
  asio::io_context context;
  asio::ip::tcp::acceptor acceptor(context, {asio::ip::address_v4::loopback(), 0});
  return acceptor.local_endpoint().port();
}

enum class Line { tcp, rtu };

class WatlowAgainstPymodbus : public testing::TestWithParam<Line> {
 protected:
  void SetUp() override {
    if (!peer_can_run())
      GTEST_SKIP() << "NOT TESTED: needs python3-pymodbus, python3-serial-asyncio and socat "
                      "(apt-get install)";
    const bool tcp = GetParam() == Line::tcp;
    const std::string port = std::to_string(free_port());
    address = tcp ? "127.0.0.1:" + port : folder.path() + "/pid-rtu";
    peer = std::make_unique<tests::Process>(std::vector<std::string>{
        "/usr/bin/python3", DRIFTWISE_SOURCE_DIR "/tests/peers/modbus/pid_peer.py",
        tcp ? "--tcp" : "--rtu", tcp ? port : address, "--noise", "0"});
    const auto ready = peer->read_line(15s);
    ASSERT_TRUE(ready && ready->starts_with("READY")) << "the peer did not start";
  }
  void TearDown() override {
    if (!peer) return;
    peer->signal(15);  // it ends its socat then
    EXPECT_TRUE(peer->wait(5s));
  }
  DeviceDescription support(std::map<std::string, std::string> options = {}) const {
    DeviceDescription out;
    out.id = "support";
    out.kind = "watlow-ez-zone";
    out.address = address;
    out.timeout_s = 0.4;
    out.options = std::move(options);
    return out;
  }
  std::unique_ptr<Stabiliser> make(const DeviceDescription& description) {
    auto made = drivers::make_watlow_ez_zone(description, context.get_executor(), clock);
    EXPECT_TRUE(made) << made.error().message;
    return std::move(*made);
  }
  template <class T>
  T run(Awaitable<T> work) {
    return tests::run(context, std::move(work));
  }
  // Writes registers of the peer with a line of its own; a serial pair has one master only.
  void poke(int unit, int address_on_wire, std::uint16_t value) {
    watlow::ModbusMaster master(
        {"test", address, *transport::parse_address(address),
         std::make_shared<watlow::ModbusLine>(transport::SerialSettings{.baud = 9600}), unit});
    ASSERT_TRUE(master.connect(1s));
    const auto written = master.write(address_on_wire, std::span<const std::uint16_t>(&value, 1));
    ASSERT_TRUE(written) << written.error().message;
  }

  tests::TemporaryFolder folder;
  std::string address;
  std::unique_ptr<tests::Process> peer;
  asio::io_context context{1};
  tests::WallClock clock;
};

TEST_P(WatlowAgainstPymodbus, ReadsTheRoomInTheFactorysUnitAndWordOrder) {
  auto stabiliser = make(support());
  const auto reading = run(stabiliser->read());
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_NEAR(*reading->find("support_degC"), 20.0, 1e-3);
  EXPECT_NEAR(*reading->find("support_set_degC"), 20.0, 1e-5);
  EXPECT_NEAR(*reading->find("support_power_pct"), 0.0, 5.0);
  EXPECT_EQ(stabiliser->health().link, LinkState::connected);
}

TEST_P(WatlowAgainstPymodbus, WritesASetPointOnceAndSeesItTaken) {
  auto stabiliser = make(support());
  ASSERT_TRUE(run(stabiliser->set_point(21.5)));
  EXPECT_NEAR(*run(stabiliser->read())->find("support_set_degC"), 21.5, 1e-5);
  double power_pct = 0;  // the peer's loop takes a step every 50 ms
  for (const auto until = std::chrono::steady_clock::now() + 3s;
       power_pct <= 0 && std::chrono::steady_clock::now() < until;)
    power_pct = *run(stabiliser->read())->find("support_power_pct");
  EXPECT_GT(power_pct, 0.0) << "it heats towards 21.5";
  ASSERT_TRUE(run(stabiliser->set_point(21.5)));
  const auto lines = stabiliser->recent_exchanges();
  for (std::size_t i = lines.size() - 5; i < lines.size(); ++i)  // of the second set_point
    EXPECT_THAT(lines[i], testing::Not(HasSubstr("write")))
        << "the memory behind a set point wears out";
}

TEST_P(WatlowAgainstPymodbus, TellsItsControlLoopAndTakesAnother) {
  auto stabiliser = make(support({{"heat_band_k", "3"}}));
  auto* loop = dynamic_cast<TunableLoop*>(stabiliser.get());
  ASSERT_NE(loop, nullptr);
  const auto before = run(loop->tuning());
  ASSERT_TRUE(before) << before.error().message;
  EXPECT_TRUE(before->heat_band_k && before->integral_s);
  EXPECT_EQ(loop->declared_tuning().heat_band_k, 3);
  LoopTuning wanted;
  wanted.heat_band_k = wanted.cool_band_k = 3;  // the peer has one band
  wanted.integral_s = 120;
  const auto after = run(loop->set_tuning(wanted));
  ASSERT_TRUE(after) << after.error().message;
  EXPECT_NEAR(*after->heat_band_k, 3, 1e-6);
  EXPECT_NEAR(*after->integral_s, 120, 1e-6);
  EXPECT_NEAR(*after->derivative_s, *before->derivative_s, 1e-6);
  EXPECT_TRUE(differences_of(loop->declared_tuning(), *after).empty());
  wanted.heat_band_k = -1;
  const auto refused = run(loop->set_tuning(wanted));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "OUT_OF_RANGE");
  EXPECT_THAT(refused.error().message, HasSubstr("nothing was written"));
}

TEST_P(WatlowAgainstPymodbus, RefusesTheWrongUnit) {
  const auto done = run(make(support({{"unit", "C"}}))->prepare());
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().reason, "UNIT_MISMATCH");
  EXPECT_THAT(done.error().message, HasSubstr("30 (F)"));
}

TEST_P(WatlowAgainstPymodbus, ReadsCelsiusWhenThatIsOnTheWire) {
  poke(1, watlow::address::kUnit, watlow::kUnitCelsius);
  auto stabiliser = make(support({{"unit", "C"}}));
  ASSERT_TRUE(run(stabiliser->set_point(20.25)));
  EXPECT_NEAR(*run(stabiliser->read())->find("support_set_degC"), 20.25, 1e-6);
}

TEST_P(WatlowAgainstPymodbus, WritesNothingWhenTheProcessValueMakesNoSense) {
  for (const auto& wrong : {std::pair("word_order", "high_first"), std::pair("unit", "C")}) {
    auto stabiliser = make(support({{wrong.first, wrong.second}, {"check_unit", "off"}}));
    const auto done = run(stabiliser->set_point(21));
    ASSERT_FALSE(done) << wrong.first;
    EXPECT_EQ(done.error().reason, "IMPLAUSIBLE_PV") << wrong.first;
  }
  EXPECT_NEAR(*run(make(support())->read())->find("support_set_degC"), 20.0, 1e-5);
}

TEST_P(WatlowAgainstPymodbus, KeepsTheSetPointInTheRoomsRange) {
  EXPECT_EQ(run(make(support())->set_point(80)).error().reason, "SET_POINT");
}

TEST_P(WatlowAgainstPymodbus, ReportsAnOpenSensorAsMissing) {
  poke(10, 0, 1);
  auto stabiliser = make(support());
  const auto reading = run(stabiliser->read());
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_TRUE(is_missing(*reading->find("support_degC")));
  EXPECT_EQ(run(stabiliser->set_point(21)).error().reason, "INPUT_ERROR");
}

TEST_P(WatlowAgainstPymodbus, TimesOutOnAUnitThatIsNotThere) {
  const auto reading = run(make(support({{"unit_id", "77"}}))->read());
  ASSERT_FALSE(reading);
  EXPECT_EQ(reading.error().code, ErrorCode::deadline_exceeded) << reading.error().message;
  EXPECT_THAT(reading.error().message, HasSubstr("unit 77"));
}

TEST_P(WatlowAgainstPymodbus, PassesAnExceptionOn) {
  auto stabiliser = make(support({{"zone", "2"}}));  // this one has no second zone
  const auto reading = run(stabiliser->read());
  ASSERT_FALSE(reading);
  EXPECT_EQ(reading.error().reason, "MODBUS_EXCEPTION") << reading.error().message;
  EXPECT_THAT(reading.error().message, HasSubstr("7490"));
}

class WatlowOverTcp : public WatlowAgainstPymodbus {};  // a pty would go with its peer
TEST_P(WatlowOverTcp, ComesBackWhenTheDeviceDoes) {
  auto stabiliser = make(support());
  ASSERT_TRUE(run(stabiliser->read()));
  peer->signal(15);
  ASSERT_TRUE(peer->wait(5s));
  const auto away = run(stabiliser->read());
  ASSERT_FALSE(away);
  EXPECT_EQ(away.error().code, ErrorCode::unavailable) << away.error().message;
  EXPECT_FALSE(run(stabiliser->read()));
  *peer =
      tests::Process({"/usr/bin/python3", DRIFTWISE_SOURCE_DIR "/tests/peers/modbus/pid_peer.py",
                      "--tcp", address.substr(address.find(':') + 1), "--noise", "0"});
  ASSERT_TRUE(peer->read_line(15s));
  EXPECT_TRUE(run(stabiliser->read()));
  EXPECT_EQ(stabiliser->health().reconnects, 1);
}

INSTANTIATE_TEST_SUITE_P(Tcp, WatlowOverTcp, testing::Values(Line::tcp));
INSTANTIATE_TEST_SUITE_P(Lines, WatlowAgainstPymodbus, testing::Values(Line::tcp, Line::rtu),
                         [](const auto& row) { return row.param == Line::tcp ? "Tcp" : "Rtu"; });

}  // namespace
}  // namespace driftwise
