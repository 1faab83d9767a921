#include "drivers/transport/shared_line.h"

#include <gmock/gmock.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <cstring>
#include <deque>
#include <filesystem>
#include <map>

#include "drivers/lds1000/newport_lds1000.h"
#include "drivers/touch_probe/nd28x_probe.h"
#include "drivers/watlow_ez_zone/registers.h"
#include "drivers/watlow_ez_zone/watlow_ez_zone.h"
#include "server/core/ports/spawn.h"
#include "tests/support/manual_clock.h"
#include "tests/unit/drivers/pty_peer.h"

namespace driftwise {
namespace {

constexpr int kReads = 10;

// Devices that are made together and read at the same time, as the recorder does.
class DevicesOnOneSerialLine : public testing::Test {
 protected:
  DeviceDescription device(std::string id, const std::string& path,
                           std::map<std::string, std::string> options) const {
    DeviceDescription out;
    out.id = std::move(id);
    out.address = path;
    out.timeout_s = 0.5;
    out.options = std::move(options);
    return out;
  }
  template <class Port>
  void read_all_at_once(const std::vector<std::unique_ptr<Port>>& devices) {
    const auto read_one = [](Port& one, std::vector<std::string>& failures,
                             std::map<std::string, double>& last) -> Awaitable<void> {
      for (int i = 0; i < kReads; ++i) {
        const auto reading = co_await one.read();
        if (reading)
          last[one.description().id] = reading->values.front().value;
        else
          failures.push_back(reading.error().message);
      }
    };
    for (const auto& one : devices)
      spawn(context.get_executor(), read_one(*one, failures_, last_values));
    context.run();
  }

  asio::io_context context{1};
  tests::WallClock clock;
  SharedByAddress shared;
  std::vector<std::string> failures_;
  std::map<std::string, double> last_values;
};

std::string answer_as_nd287(std::string& received) {
  constexpr std::string_view kIdentity =
      "\x1b"
      "A0000\r";
  std::string reply;
  for (;;) {
    if (received.starts_with(kIdentity)) {
      received.erase(0, kIdentity.size());
      reply +=
          "\x02"
          "ND 287    \r\n123456 78 \r\nV1.02     \r\n";
    } else if (received.starts_with('\x02')) {
      received.erase(0, 1);
      reply += "+     1.23450  \r\n";
    } else {
      return reply;
    }
  }
}

TEST_F(DevicesOnOneSerialLine, OneReadOutForTwoCoordinatesAnswersBoth) {
  const tests::PtyPeer peer(answer_as_nd287);
  const std::string link = testing::TempDir() + "driftwise-shared-line-test";
  std::filesystem::remove(link);
  std::filesystem::create_symlink(peer.path(), link);
  std::vector<std::unique_ptr<touch_probe::Nd28xProbe>> probes;
  for (const char* symbol : {"z", "x"}) {
    auto described = device(std::string("probe-") + symbol, *symbol == 'z' ? peer.path() : link,
                            {{"data_bits", "8"}, {"parity", "none"}});
    described.become<LengthSettings>().channel = {symbol, "mm"};
    probes.push_back(std::make_unique<touch_probe::Nd28xProbe>(
        described, *touch_probe::read_options(described),
        *transport::parse_address(described.address), context.get_executor(), clock, &shared));
  }
  read_all_at_once(probes);
  std::filesystem::remove(link);
  EXPECT_THAT(failures_, testing::IsEmpty());
  EXPECT_EQ(last_values["probe-z"], 1.2345);
  EXPECT_EQ(last_values["probe-x"], 1.2345);
}

// Names as udev makes them: absent until the adapter is plugged in, which may be after the start.
TEST_F(DevicesOnOneSerialLine, TwoNamesOfAPortThatIsPluggedInLaterAreOneLine) {
  const std::string stem = testing::TempDir() + "driftwise-late-line-" + std::to_string(getpid());
  std::vector<std::unique_ptr<touch_probe::Nd28xProbe>> probes;
  for (const char* symbol : {"z", "x"}) {
    auto described = device(std::string("probe-") + symbol, stem + symbol,
                            {{"data_bits", "8"}, {"parity", "none"}});
    described.become<LengthSettings>().channel = {symbol, "mm"};
    probes.push_back(std::make_unique<touch_probe::Nd28xProbe>(
        described, *touch_probe::read_options(described),
        *transport::parse_address(described.address), context.get_executor(), clock, &shared));
  }
  const tests::PtyPeer peer(answer_as_nd287);
  for (const char* symbol : {"z", "x"}) std::filesystem::create_symlink(peer.path(), stem + symbol);
  read_all_at_once(probes);
  for (const char* symbol : {"z", "x"}) std::filesystem::remove(stem + symbol);
  EXPECT_THAT(failures_, testing::IsEmpty());
  EXPECT_EQ(last_values["probe-z"], 1.2345);
  EXPECT_EQ(last_values["probe-x"], 1.2345);
}

// An LDS1000 behind a serial server: whatever the line says goes to every connection, as ser2net
// and terminal servers do, and the device needs a while for each command.
class SerialServer {
 public:
  explicit SerialServer(asio::io_context& context)
      : context_(context), acceptor_(context, {asio::ip::make_address("127.0.0.1"), 0}) {
    accept();
  }
  std::string address() const {
    return "127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port());
  }
  void close() {
    acceptor_.close();
    for (const auto& one : connections_) one->socket.close();
  }

 private:
  struct Connection {
    explicit Connection(asio::ip::tcp::socket accepted) : socket(std::move(accepted)) {}
    asio::ip::tcp::socket socket;
    std::array<char, 256> bytes{};
    std::string received;
  };
  void accept() {
    acceptor_.async_accept([this](auto error, asio::ip::tcp::socket socket) {
      if (error) return;
      connections_.push_back(std::make_shared<Connection>(std::move(socket)));
      read(connections_.back());
      accept();
    });
  }
  void read(const std::shared_ptr<Connection>& one) {
    one->socket.async_read_some(asio::buffer(one->bytes), [this, one](auto error, auto count) {
      if (error) return;
      one->received.append(one->bytes.data(), count);
      for (std::size_t end = 0; (end = one->received.find('\r')) != std::string::npos;) {
        commands_.push_back(one->received.substr(0, end));
        one->received.erase(0, end + 1);
      }
      execute_next();
      read(one);
    });
  }
  void execute_next() {
    if (executing_ || commands_.empty()) return;
    executing_ = true;
    timer_.expires_after(std::chrono::milliseconds(3));
    timer_.async_wait([this](auto) {
      const auto reply = answer(commands_.front());
      commands_.pop_front();
      executing_ = false;
      for (const auto& one : connections_) {
        boost::system::error_code ignored;
        if (!reply.empty()) asio::write(one->socket, asio::buffer(reply), ignored);
      }
      execute_next();
    });
  }
  static std::string answer(const std::string& command) {
    static const std::map<std::string, std::string> kAnswers{
        {"VE", "VE LDS1000 Controller Version 3.10"},
        {"TE", "TE@"},
        {"MS", "MS@"},
        {"XI", "XI100"},
        {"1TA", "1TA,RT,04512,0,2,sec,00102,00241"},
        {"2TA", "2TA,RT,04512,0,2,sec,00102,00241"},
        {"1TP", "1TP12.2"},
        {"2TP", "2TP-5.1"}};
    const auto found = kAnswers.find(command);
    return found == kAnswers.end() ? std::string() : found->second + "\r\n";
  }

  asio::io_context& context_;
  asio::ip::tcp::acceptor acceptor_;
  asio::steady_timer timer_{context_};
  std::vector<std::shared_ptr<Connection>> connections_;
  std::deque<std::string> commands_;
  bool executing_ = false;
};

TEST_F(DevicesOnOneSerialLine, DevicesBehindOneSerialServerTakeTurns) {
  SerialServer server(context);
  std::vector<std::unique_ptr<Instrument>> tilts;
  for (const int axis : {1, 2}) {
    auto described = device("tilt-" + std::to_string(axis), server.address(), {});
    AngleDescription angle;
    angle.channel = {axis == 1 ? "ry" : "rz", "arcsec"};
    angle.device_axis = axis;
    described.become<AngleSettings>().angles.push_back(angle);
    auto made = drivers::make_newport_lds1000(described, context.get_executor(), clock, &shared);
    ASSERT_TRUE(made) << made.error().message;
    tilts.push_back(std::move(*made));
  }
  constexpr int kReadsEach = 3;
  int left = kReadsEach * static_cast<int>(tilts.size());
  const auto read_one = [&](Instrument& tilt) -> Awaitable<void> {
    for (int i = 0; i < kReadsEach; ++i) {
      const auto reading = co_await tilt.read();
      if (reading)
        last_values[tilt.description().id] = reading->values.front().value;
      else
        failures_.push_back(reading.error().message);
      if (--left == 0) server.close();
    }
  };
  for (const auto& one : tilts) spawn(context.get_executor(), read_one(*one));
  context.run();
  EXPECT_THAT(failures_, testing::IsEmpty());
  EXPECT_EQ(last_values["tilt-1"], 12.2);
  EXPECT_EQ(last_values["tilt-2"], -5.1);
}

std::string with_checksum(std::string frame) {
  unsigned sum = 0xffff;
  for (const char byte : frame) {
    sum ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) sum = (sum & 1) != 0 ? (sum >> 1) ^ 0xA001u : sum >> 1;
  }
  return frame + static_cast<char>(sum & 0xff) + static_cast<char>(sum >> 8);
}

// Two EZ-ZONE loops on one bus: unit 1 at 20 degC, unit 2 at 30 degC, in Celsius.
std::string answer_as_two_watlows(std::string& received) {
  constexpr std::size_t kRequest = 8;
  std::string reply;
  while (received.size() >= kRequest) {
    const std::string request = received.substr(0, kRequest);
    received.erase(0, kRequest);
    const auto word_at = [&](std::size_t i) {
      return static_cast<unsigned char>(request[i]) * 256 +
             static_cast<unsigned char>(request[i + 1]);
    };
    const int first = word_at(2), count = word_at(4);
    const float degc = request[0] == 1 ? 20.0f : 30.0f;
    std::vector<std::uint16_t> words(static_cast<std::size_t>(count));
    if (first == watlow::address::kUnit) words[0] = watlow::kUnitCelsius;
    if (first == watlow::address::kProcessValue || first == watlow::address::kSetPoint) {
      const auto packed = watlow::pack_float(degc, watlow::WordOrder::low_first);
      words[0] = packed[0];
      words[1] = packed[1];
      if (count > 2) words[2] = watlow::kInputGood;
    }
    std::string answer{request[0], 3, static_cast<char>(2 * count)};
    for (const auto word : words) {
      answer += static_cast<char>(word >> 8);
      answer += static_cast<char>(word & 0xff);
    }
    reply += with_checksum(answer);
  }
  return reply;
}

TEST_F(DevicesOnOneSerialLine, TwoUnitsOfOneModbusLineAnswerEachForItself) {
  const tests::PtyPeer peer(answer_as_two_watlows);
  std::vector<std::unique_ptr<Stabiliser>> loops;
  for (const char* unit : {"1", "2"}) {
    auto made = drivers::make_watlow_ez_zone(
        device(std::string("support-") + unit, peer.path(), {{"unit", "C"}, {"unit_id", unit}}),
        context.get_executor(), clock, &shared);
    ASSERT_TRUE(made) << made.error().message;
    loops.push_back(std::move(*made));
  }
  read_all_at_once(loops);
  EXPECT_THAT(failures_, testing::IsEmpty());
  EXPECT_EQ(last_values["support-1"], 20.0);
  EXPECT_EQ(last_values["support-2"], 30.0);
  loops.front()->close();  // one that leaves the line leaves it to the other
  context.restart();
  read_all_at_once(loops);
  EXPECT_THAT(failures_, testing::IsEmpty());
}

TEST_F(DevicesOnOneSerialLine, AUnitThatNamesAnotherBaudRateIsRefused) {
  const auto first = drivers::make_watlow_ez_zone(device("support-1", "/dev/no-such-port", {}),
                                                  context.get_executor(), clock, &shared);
  const auto second = drivers::make_watlow_ez_zone(
      device("support-2", "/dev/no-such-port", {{"unit_id", "2"}, {"baud", "19200"}}),
      context.get_executor(), clock, &shared);
  EXPECT_TRUE(first);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().reason, "BAD_OPTION");
}

TEST(SharedKey, IsTheSameForEveryNameOfOnePortAlsoBeforeItIsThere) {
  const auto key = [](const std::string& text) {
    return transport::shared_key(*transport::parse_address(text), text);
  };
  EXPECT_EQ(key("/dev/../dev/null"), key("/dev/null"));
  EXPECT_EQ(key("/dev/../dev/no-such-port"), key("/dev/no-such-port"));
  EXPECT_NE(key("/dev/no-such-port"), key("/dev/null"));
  EXPECT_EQ(key("scanner.lab:1394"), "scanner.lab:1394") << "no resolver is asked";
}

}  // namespace
}  // namespace driftwise
