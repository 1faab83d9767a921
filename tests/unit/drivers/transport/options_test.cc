#include "drivers/transport/options.h"

#include <gmock/gmock.h>

#include "drivers/transport/address.h"
#include "drivers/transport/back_off.h"
#include "drivers/transport/clock_anchor.h"
#include "drivers/transport/device_clock.h"

namespace driftwise::transport {
namespace {

using testing::HasSubstr;

DeviceDescription device_with(std::map<std::string, std::string> options) {
  DeviceDescription out;
  out.id = "axis";
  out.kind = "pi-gcs";
  out.options = std::move(options);
  return out;
}

TEST(Options, GiveDefaultsWhereNothingIsSaid) {
  const auto device = device_with({});
  OptionReader reader(device);
  EXPECT_EQ(reader.choice("reference", "FRF", {"FRF", "INI"}), "FRF");
  EXPECT_TRUE(reader.on_off("x", true));
  EXPECT_EQ(reader.number("y", 2.5, 0, 10), 2.5);
  EXPECT_TRUE(reader.finish());
}

TEST(Options, NameAnUnknownOneWithTheKnown) {
  const auto device = device_with({{"refrence", "FRF"}});
  OptionReader reader(device);
  reader.choice("reference", "FRF", {"FRF", "INI"});
  const auto result = reader.finish();
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().reason, "BAD_OPTION");
  EXPECT_THAT(result.error().message,
              testing::AllOf(HasSubstr("axis"), HasSubstr("refrence"), HasSubstr("reference")));
}

TEST(Options, SayWhatAValueMayBe) {
  for (const char* value : {"", "frf", "FRF "}) {
    const auto device = device_with({{"reference", value}});
    OptionReader reader(device);
    EXPECT_EQ(reader.choice("reference", "FRF", {"FRF", "INI"}), "FRF");
    ASSERT_FALSE(reader.finish());
    EXPECT_THAT(reader.finish().error().message, HasSubstr("FRF | INI"));
  }
  for (const char* value : {"", "1x", "nan", "-1", "11", "0x5", "1e400"}) {
    const auto device = device_with({{"n", value}});
    OptionReader reader(device);
    reader.number("n", 1, 0, 10);
    EXPECT_FALSE(reader.finish()) << value;
  }
  const auto device = device_with({{"n", "2.5"}});
  OptionReader reader(device);
  reader.integer("n", 1, 0, 10);
  EXPECT_FALSE(reader.finish());
}

TEST(Address, IsHostAndPortOrAPath) {
  const auto tcp = parse_address("scanner.lab:1394");
  ASSERT_TRUE(tcp);
  EXPECT_EQ(std::get<TcpAddress>(*tcp).host, "scanner.lab");
  EXPECT_EQ(std::get<TcpAddress>(*tcp).port, 1394);
  EXPECT_EQ(std::get<TcpAddress>(*parse_address("[::1]:50000")).host, "::1");
  EXPECT_EQ(std::get<SerialAddress>(*parse_address("/dev/ttyUSB0")).path, "/dev/ttyUSB0");
  for (const char* bad : {"", "host", ":1394", "host:", "host:0", "host:65536", "host:1394x",
                          "::1:5", "[]:5", "[::1:5"})
    EXPECT_FALSE(parse_address(bad)) << bad;
}

TEST(BackOff, IsImmediateOnceThenDoublesUpToItsBound) {
  using std::chrono::milliseconds;
  BackOff back_off(7, {milliseconds(100), milliseconds(1000)});
  EXPECT_EQ(back_off.after_failure(), milliseconds(0));
  for (const int whole : {100, 200, 400, 800, 1000, 1000, 1000}) {
    const auto wait = back_off.after_failure();
    EXPECT_GE(wait, milliseconds(whole / 2));
    EXPECT_LE(wait, milliseconds(whole));
  }
  back_off.after_success();
  EXPECT_EQ(back_off.after_failure(), milliseconds(0));
}

TEST(BackOff, IsTheSameForTheSameSeed) {
  BackOff one(seed_from("axis"), {}), two(seed_from("axis"), {}), other(seed_from("scanner"), {});
  std::vector<std::int64_t> a, b, c;
  for (int i = 0; i < 6; ++i) {
    a.push_back(one.after_failure().count());
    b.push_back(two.after_failure().count());
    c.push_back(other.after_failure().count());
  }
  EXPECT_EQ(a, b);
  EXPECT_NE(a, c);
}

TEST(ClockAnchor, TightensWithTheFastestAnswer) {
  // The device's second 0 is cell second 100. Answers arrive 0.5 s, then 0.1 s late.
  const auto at = [](double s) { return CellTime{} + nanoseconds_from_s(s); };
  ClockAnchor anchor;
  anchor.observe(1.0, 2.0, at(100.9), at(102.5));
  EXPECT_NEAR(seconds_from(anchor.cell_time(2.0) - at(0)), 102.5, 1e-9);
  anchor.observe(11.0, 12.0, at(110.9), at(112.1));
  EXPECT_NEAR(seconds_from(anchor.cell_time(12.0) - at(0)), 112.1, 1e-9);
  anchor.observe(21.0, 22.0, at(120.9), at(123.0));  // a slow answer loosens nothing
  EXPECT_NEAR(seconds_from(anchor.cell_time(22.0) - at(0)), 122.1, 1e-9);
}

TEST(DeviceClock, FollowsADriftAndTellsAJump) {
  const auto at = [](double s) { return CellTime{} + nanoseconds_from_s(s); };
  DeviceClock device_clock;
  double off_s = -250;
  const auto reading_at = [&](double s) {  // averages for half a second, 0.1 s after the question
    return device_clock.observe(at(s + 0.1 + off_s), at(s + 0.6 + off_s), at(s), at(s + 0.65));
  };
  for (int i = 1; i <= 10'000; ++i) {
    off_s += 10 * 1e-4;  // 100 ppm fast
    ASSERT_FALSE(reading_at(10.0 * i)) << i;
    ASSERT_NEAR(seconds_from(*device_clock.offset()), off_s, 0.11);
  }
  off_s += 3600;
  const auto forward = reading_at(200'000);
  ASSERT_TRUE(forward);
  EXPECT_NEAR(seconds_from(*forward), 3600, 0.2);
  EXPECT_FALSE(reading_at(200'010)) << "told once";
  EXPECT_NEAR(seconds_from(device_clock.cell_time(at(200'020 + off_s)) - at(200'020)), 0, 0.11);
  off_s -= 600;
  const auto back = reading_at(200'030);
  ASSERT_TRUE(back);
  EXPECT_NEAR(seconds_from(*back), -600, 0.2);
}

// A simulated cell at 200 x follows a change of speed 2 ms later: 0.4 s of cell time.
TEST(DeviceClock, TheCellsOwnChangeOfSpeedIsNoJump) {
  const auto at = [](double s) { return CellTime{} + nanoseconds_from_s(s); };
  DeviceClock device_clock;
  EXPECT_FALSE(device_clock.observe(at(10.1), at(10.6), at(10), at(10.7), 200));
  EXPECT_FALSE(device_clock.observe(at(20.5), at(21.0), at(20), at(20.7), 200));
  EXPECT_NEAR(seconds_from(*device_clock.offset()), 0.3, 1e-6);
  EXPECT_TRUE(device_clock.observe(at(3630.1), at(3630.6), at(30), at(30.7), 200));
}

// Between two asked at long intervals a quartz may drift by more than an exchange is wide.
TEST(DeviceClock, ALongAbsenceIsNoJump) {
  const auto at = [](double s) { return CellTime{} + nanoseconds_from_s(s); };
  DeviceClock device_clock;
  EXPECT_FALSE(device_clock.observe(at(10.1), at(10.6), at(10), at(10.7)));
  EXPECT_FALSE(device_clock.observe(at(86411.1), at(86411.6), at(86410), at(86410.7)));
}

TEST(ClockAnchor, FollowsAClockThatDriftsAndOneThatIsReset) {
  const auto at = [](double s) { return CellTime{} + nanoseconds_from_s(s); };
  ClockAnchor anchor;
  for (int i = 1; i <= 1000; ++i) {  // 100 ppm slow: 1 s behind after 10000 s
    const double device = 10.0 * i * (1 - 1e-4);
    anchor.observe(device, device, at(10.0 * i - 0.05), at(10.0 * i + 0.05));
    EXPECT_NEAR(seconds_from(anchor.cell_time(device) - at(0)), 10.0 * i, 0.051);
  }
  anchor.observe(1.0, 1.0, at(20000.0), at(20000.1));  // switched off and on
  EXPECT_NEAR(seconds_from(anchor.cell_time(1.0) - at(0)), 20000.0, 0.11);
}

}  // namespace
}  // namespace driftwise::transport
