#include "drivers/simulated/emulators/watlow_ez_zone/watlow_emulator.h"

#include <gtest/gtest.h>

#include <bit>
#include <vector>

#include "tests/unit/emulators/conversation.h"
#include "tests/unit/emulators/test_plant.h"

namespace driftwise::simulated {
namespace {

std::string bytes(const std::vector<int>& list) {
  std::string out;
  for (const int one : list) out += static_cast<char>(one);
  return out;
}

struct Watlow {
  explicit Watlow(Settings settings = {}, Link link = Link::tcp)
      : emulator(plant, switches_with(WatlowRegisters::switches(), settings), 0, kStart),
        line(emulator, link) {}
  // One Modbus TCP exchange: request without header; answer without header.
  std::string ask(const std::string& pdu, int unit = 1) {
    const std::string head = bytes({0x12, 0x34, 0, 0, 0, static_cast<int>(pdu.size()) + 1, unit});
    const std::string reply = line.ask(head + pdu);
    if (reply.empty()) return "";
    EXPECT_EQ(reply.substr(0, 4), head.substr(0, 4));
    EXPECT_EQ(static_cast<unsigned char>(reply[5]), reply.size() - 6);
    return reply.substr(7);
  }
  std::string read(int address, int count) {
    return ask(bytes({3, address >> 8, address & 255, count >> 8, count & 255}));
  }
  static std::string words(std::initializer_list<int> list) {
    std::string out = bytes({3, static_cast<int>(list.size()) * 2});
    for (const int word : list) out += bytes({word >> 8, word & 255});
    return out;
  }
  TestPlant plant;
  WatlowEmulator emulator;
  Conversation line;
};

TEST(Watlow, GivesFahrenheitWithTheLowWordFirst) {
  // The maker's example: 75.0 is 0x42960000, sent as 0x0000, 0x4296.
  Watlow watlow;
  watlow.plant.zones[0].set_point_degc = (75.0 - 32.0) / 1.8;
  EXPECT_EQ(watlow.read(2160, 2), Watlow::words({0x0000, 0x4296}));
}

TEST(Watlow, HighWordFirstAndCelsiusAreSwitches) {
  Watlow watlow({{"low_word_first", "false"}, {"fahrenheit", "false"}});
  watlow.plant.zones[0].process_degc = 22.5;  // 0x41B40000
  EXPECT_EQ(watlow.read(360, 2), Watlow::words({0x41B4, 0x0000}));
  EXPECT_EQ(watlow.read(2490, 1), Watlow::words({15}));
}

TEST(Watlow, UnitsOnTheWireMayBeWritten) {
  Watlow watlow;
  EXPECT_EQ(watlow.read(2490, 1), Watlow::words({30}));
  EXPECT_EQ(watlow.ask(bytes({6, 9, 0xBA, 0, 15})), bytes({6, 9, 0xBA, 0, 15}));
  watlow.plant.zones[0].process_degc = 22.5;
  EXPECT_EQ(watlow.read(360, 2), Watlow::words({0x0000, 0x41B4}));
  EXPECT_EQ(watlow.ask(bytes({6, 9, 0xBA, 0, 16})), bytes({0x86, 3}));
}

TEST(Watlow, WritesASetPointInOneOrTwoPieces) {
  Watlow watlow({{"fahrenheit", "false"}});
  EXPECT_EQ(watlow.ask(bytes({16, 0x08, 0x70, 0, 2, 4, 0, 0, 0x41, 0xB4})),
            bytes({16, 0x08, 0x70, 0, 2}));
  EXPECT_EQ(watlow.plant.zones[0].set_point_degc, 22.5);
  EXPECT_EQ(watlow.ask(bytes({6, 0x08, 0x71, 0x41, 0xA0})), bytes({6, 0x08, 0x71, 0x41, 0xA0}));
  EXPECT_EQ(watlow.plant.zones[0].set_point_degc, 20.0);
}

TEST(Watlow, ReadsNeighboursInOneRequest) {
  Watlow watlow;
  EXPECT_EQ(watlow.read(360, 3).size(), 2 + 6u);
  EXPECT_EQ(watlow.read(362, 1), Watlow::words({61}));
  watlow.plant.zones[0].sensor_open = true;
  EXPECT_EQ(watlow.read(362, 1), Watlow::words({65}));
}

TEST(Watlow, ModeAndOpenLoopReachThePlant) {
  Watlow watlow;
  EXPECT_EQ(watlow.read(1880, 1), Watlow::words({10}));
  watlow.ask(bytes({16, 0x08, 0x72, 0, 2, 4, 0, 0, 0x42, 0x48}));  // 2162: 50 %
  watlow.ask(bytes({6, 0x07, 0x58, 0, 54}));                       // 1880: manual
  EXPECT_EQ(watlow.plant.mode, Plant::StabiliserMode::manual);
  EXPECT_EQ(watlow.plant.manual_pct, 50);
  watlow.ask(bytes({6, 0x07, 0x58, 0, 62}));
  EXPECT_EQ(watlow.plant.mode, Plant::StabiliserMode::off);
  EXPECT_EQ(watlow.ask(bytes({6, 0x07, 0x58, 0, 11})), bytes({0x86, 3}));
}

TEST(Watlow, TuningBandsAreDifferencesOfTemperature) {
  Watlow watlow;  // degF: a band of 1.8 is one kelvin
  const auto raw = std::bit_cast<std::uint32_t>(1.8f);
  watlow.ask(bytes({16, 0x07, 0x62, 0, 2, 4}) +
             bytes({static_cast<int>(raw >> 8 & 255), static_cast<int>(raw & 255),
                    static_cast<int>(raw >> 24), static_cast<int>(raw >> 16 & 255)}));
  EXPECT_NEAR(watlow.plant.heat_band_k, 1.0, 1e-7);
}

TEST(Watlow, AZoneLiesFiveThousandFurther) {
  Watlow watlow({{"zones", "2"}, {"fahrenheit", "false"}});
  EXPECT_EQ(watlow.read(5360, 2), Watlow::words({0x0000, 0x4198}));  // 19.0
  EXPECT_EQ(Watlow().read(5360, 2), bytes({0x83, 2}));
}

struct WatlowRefusal {
  const char* name;
  std::vector<int> request, answer;
};
class WatlowRefuses : public testing::TestWithParam<WatlowRefusal> {};
TEST_P(WatlowRefuses, WithAnException) {
  EXPECT_EQ(Watlow().ask(bytes(GetParam().request)), bytes(GetParam().answer));
}
INSTANTIATE_TEST_SUITE_P(
    Table, WatlowRefuses,
    testing::Values(
        WatlowRefusal{"Function4", {4, 1, 0x68, 0, 2}, {0x84, 1}},
        WatlowRefusal{"Coils", {1, 0, 0, 0, 1}, {0x81, 1}},
        WatlowRefusal{"NoSuchRegister", {3, 0, 0, 0, 1}, {0x83, 2}},
        WatlowRefusal{"RunsPastTheEnd", {3, 1, 0x68, 0, 5}, {0x83, 2}},
        WatlowRefusal{"ReadNothing", {3, 1, 0x68, 0, 0}, {0x83, 3}},
        WatlowRefusal{"ReadTooMuch", {3, 1, 0x68, 0, 126}, {0x83, 3}},
        WatlowRefusal{"WriteProcessValue", {6, 1, 0x68, 0, 1}, {0x86, 2}},
        WatlowRefusal{"SetPointTooHot", {16, 8, 0x70, 0, 2, 4, 0, 0, 0x44, 0x7A}, {0x90, 3}},
        WatlowRefusal{"SetPointNoNumber", {16, 8, 0x70, 0, 2, 4, 0, 0, 0x7F, 0xC0}, {0x90, 3}},
        WatlowRefusal{"CountDisagrees", {16, 8, 0x70, 0, 2, 2, 0, 0}, {0x90, 3}},
        WatlowRefusal{"Truncated", {3, 1}, {0x83, 3}}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(Watlow, ARefusedWriteChangesNothing) {
  Watlow watlow({{"fahrenheit", "false"}});
  // Set point 22.5 and an open-loop power of 1000 %: neither is taken.
  EXPECT_EQ(watlow.ask(bytes({16, 8, 0x70, 0, 4, 8, 0, 0, 0x41, 0xB4, 0, 0, 0x44, 0x7A})),
            bytes({0x90, 3}));
  EXPECT_EQ(watlow.plant.zones[0].set_point_degc, 23.0);
}

TEST(Watlow, AnotherUnitIsSilent) {
  Watlow watlow;
  EXPECT_EQ(watlow.ask(bytes({3, 1, 0x68, 0, 2}), 2), "");
  EXPECT_NE(Watlow({{"unit_id", "7"}}).ask(bytes({3, 1, 0x68, 0, 2}), 7), "");
}

TEST(Watlow, PutsAFrameTogetherFromPieces) {
  Watlow watlow;
  for (const char byte : bytes({0, 1, 0, 0, 0, 6, 1, 3, 1, 0x68, 0})) watlow.line.say({&byte, 1});
  EXPECT_EQ(watlow.line.hear(), "");
  EXPECT_EQ(watlow.line.ask(bytes({2, 0, 2, 0, 0, 0, 6, 1, 3, 1, 0x68, 0, 2})).size(), 26u)
      << "two answers";
}

TEST(WatlowRtu, ChecksTheSumAndAnswersWithOne) {
  // The example of the Modbus serial line specification, 2.5.1.2: slave 2, function 7 has CRC
  // 0x1241.
  EXPECT_EQ(modbus_crc(bytes({2, 7})), 0x1241);
  Watlow watlow({}, Link::serial);
  std::string request = bytes({1, 3, 1, 0x6A, 0, 1});
  const auto crc = modbus_crc(request);
  request += bytes({crc & 255, crc >> 8});
  const std::string reply = watlow.line.ask(request);
  ASSERT_EQ(reply.size(), 7u);
  EXPECT_EQ(reply.substr(0, 5), bytes({1, 3, 2, 0, 61}));
  EXPECT_EQ(modbus_crc(reply), 0) << "the sum over a frame with its own sum is zero";
  request[3] ^= 1;
  EXPECT_EQ(watlow.line.ask(request), "");
}

TEST(WatlowRtu, ASilenceEndsAnUnfinishedFrame) {
  Watlow watlow({}, Link::serial);
  std::string request = bytes({1, 3, 1, 0x6A, 0, 1});
  const auto crc = modbus_crc(request);
  request += bytes({crc & 255, crc >> 8});
  watlow.line.ask(request.substr(0, 5), 0.2);
  EXPECT_EQ(watlow.line.ask(request).size(), 7u);
}

}  // namespace
}  // namespace driftwise::simulated
