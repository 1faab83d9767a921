// The driver against upsd and its dummy-ups driver: Debian's nut-server, which we did not write.

#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "drivers/all_devices.h"
#include "drivers/nut_ups/nut_ups.h"
#include "server/core/ports/made_device.h"
#include "server/formats/cell_file/cell_file.h"
#include "tests/support/process.h"
#include "tests/unit/drivers/driver_fixture.h"

namespace driftwise {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

const char* const kUpsd = "/lib/nut/upsd";  // Debian's /usr/sbin/upsd asks /etc/nut/nut.conf first
const char* const kDriver = "/lib/nut/dummy-ups";

std::uint16_t free_port() {
  const int one = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ::bind(one, reinterpret_cast<sockaddr*>(&address), sizeof address);
  ::getsockname(one, reinterpret_cast<sockaddr*>(&address), &size);
  ::close(one);
  return ntohs(address.sin_port);
}

class UpsBehindUpsd : public tests::DriverFixture {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kUpsd) || !std::filesystem::exists(kDriver))
      GTEST_SKIP() << "no " << kUpsd << ": apt-get install nut-server";
    address = "127.0.0.1:" + std::to_string(free_port());
    const auto colon = address.find(':');
    tests::write_file(folder.path() + "/ups.conf",
                      "[rack]\n  driver = dummy-ups\n  port = rack.dev\n");
    tests::write_file(folder.path() + "/upsd.conf",
                      "LISTEN 127.0.0.1 " + address.substr(colon + 1) + "\n");
    tests::write_file(folder.path() + "/upsd.users", "");
    status("OL CHRG");
    for (const char* variable :
         {"NUT_CONFPATH=", "NUT_STATEPATH=", "NUT_PIDPATH=", "NUT_ALTPIDPATH="})
      environment.push_back(variable + folder.path());
    start_driver();
    server.emplace(std::vector<std::string>{kUpsd, "-F", "-u", user()}, environment,
                   folder.path() + "/upsd.log");
  }
  static std::string user() { return ::getuid() == 0 ? "root" : std::to_string(::getuid()); }
  void start_driver() {
    driver.emplace(std::vector<std::string>{kDriver, "-a", "rack", "-F", "-u", user()}, environment,
                   folder.path() + "/driver.log");
  }
  // dummy-ups reads the file anew when its time of change is another one: in whole seconds.
  void status(const std::string& words) {
    const std::string file = folder.path() + "/rack.dev";
    tests::write_file(file, "ups.status: " + words + "\nbattery.charge: 97\n");
    timespec times[2] = {{++changes, 0}, {changes, 0}};
    ::utimensat(AT_FDCWD, file.c_str(), times, 0);
  }
  DeviceDescription rack(std::map<std::string, std::string> options = {{"ups", "rack"}}) {
    auto out = device("rack", "nut-ups");
    out.become<SupplySettings>();
    out.address = address;
    out.timeout_s = 2;
    out.options = std::move(options);
    return out;
  }
  Result<MadeDevice> make(const DeviceDescription& description) {
    const auto* kind = find_kind(drivers::all_devices(), description.kind);
    return kind->make(description, {context.get_executor(), clock});
  }
  // Reads until the condition holds, for 20 s: the driver asks its file every two seconds.
  template <class Condition>
  Result<Reading> read_until(Instrument& ups, Condition condition) {
    const auto end = std::chrono::steady_clock::now() + 20s;
    while (true) {
      auto reading = run(ups.read());
      if (condition(reading) || std::chrono::steady_clock::now() > end) return reading;
      let_pass(100ms);
    }
  }

  tests::TemporaryFolder folder;
  std::string address;
  std::vector<std::string> environment;
  std::int64_t changes = 1'700'000'000;
  std::optional<tests::Process> driver, server;
};

TEST_F(UpsBehindUpsd, TellsMainsFromBatteryAndALowBattery) {
  auto made = make(rack());
  ASSERT_TRUE(made) << made.error().message;
  auto& ups = *made->as<Instrument>();
  auto reading = read_until(ups, [](const auto& one) { return one.has_value(); });
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_EQ(*reading->find("rack_on_battery_1"), 0);
  EXPECT_EQ(*reading->find("rack_low_battery_1"), 0);
  EXPECT_EQ(*reading->find("rack_charge_pct"), 97);
  EXPECT_TRUE(is_missing(*reading->find("rack_runtime_s")));  // this supply does not say
  EXPECT_THAT(made->device().health().identity, HasSubstr("Network UPS Tools upsd"));
  status("OB DISCHRG");
  reading =
      read_until(ups, [](const auto& one) { return one && *one->find("rack_on_battery_1") == 1; });
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_EQ(*reading->find("rack_on_battery_1"), 1);
  EXPECT_EQ(*reading->find("rack_low_battery_1"), 0);
  status("OB LB");
  reading =
      read_until(ups, [](const auto& one) { return one && *one->find("rack_low_battery_1") == 1; });
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_EQ(*reading->find("rack_low_battery_1"), 1);
}

TEST_F(UpsBehindUpsd, AForcedShutdownIsAboutToTakeThePowerUnlessItWasThereAtTheStart) {
  const auto is_forced = [](const auto& one) { return one && *one->find("rack_forced_1") == 1; };
  auto made = make(rack()), later = make(rack());
  ASSERT_TRUE(made && later);
  auto& ups = *made->as<Instrument>();
  ASSERT_TRUE(read_until(ups, [](const auto& one) { return one.has_value(); }));
  status("FSD OL");
  const auto reading = read_until(ups, is_forced);
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_EQ(*reading->find("rack_low_battery_1"), 1);
  EXPECT_EQ(*reading->find("rack_on_battery_1"), 0);
  const auto at_start = run(later->as<Instrument>()->read());
  ASSERT_TRUE(at_start) << at_start.error().message;
  EXPECT_EQ(*at_start->find("rack_forced_1"), 1);
  EXPECT_EQ(*at_start->find("rack_low_battery_1"), 0);
}

TEST_F(UpsBehindUpsd, SaysThatItsDriverIsGoneAndIsBackWithIt) {
  auto made = make(rack());
  ASSERT_TRUE(made) << made.error().message;
  auto& ups = *made->as<Instrument>();
  ASSERT_TRUE(read_until(ups, [](const auto& one) { return one.has_value(); }));
  driver.reset();
  const auto gone = read_until(ups, [](const auto& one) { return !one; });
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error().reason, "UPS_STALE");
  EXPECT_THAT(gone.error().message, HasSubstr("upsdrvctl"));
  std::filesystem::remove(folder.path() + "/dummy-ups-rack");
  start_driver();
  EXPECT_TRUE(read_until(ups, [](const auto& one) { return one.has_value(); }));
}

TEST_F(UpsBehindUpsd, NamesAUpsThatIsNotThere) {
  auto made = make(rack({{"ups", "rick"}}));
  ASSERT_TRUE(made) << made.error().message;
  const auto reading = read_until(*made->as<Instrument>(), [](const auto& one) {
    return !one && one.error().reason == "UPS_NOT_THERE";
  });
  ASSERT_FALSE(reading);
  EXPECT_THAT(reading.error().message, HasSubstr("rick"));
}

TEST_F(UpsBehindUpsd, RefusesANameThatWouldBeAnotherCommand) {
  EXPECT_EQ(make(rack({{"ups", "rack\nLOGOUT"}})).error().reason, "BAD_OPTION");
  EXPECT_EQ(make(rack({{"name", "rack"}})).error().reason, "BAD_OPTION");
}

TEST(UpsInACellFile, GivesChannelsThatHoldsMayNameAndJoinsNoPoint) {
  const std::string text =
      "[cell]\nname = \"c\"\ndatabase = \"d\"\n[[device]]\nid = \"rack-1\"\nkind = \"nut-ups\"\n"
      "address = \"127.0.0.1:3493\"\nperiod_s = 5\n[[hold]]\nname = \"mains\"\n"
      "channel = \"rack_1_on_battery_1\"\nabove = 0.5\n[[hold]]\nname = \"battery\"\n"
      "channel = \"rack_1_low_battery_1\"\nabove = 0.5\naction = \"end-daemon\"\n";
  const auto cell = formats::parse_cell_file(text, "cell.toml", drivers::all_devices());
  ASSERT_TRUE(cell) << cell.error().message;
  EXPECT_EQ(cell->devices[0].role(), DeviceRole::supply);
  EXPECT_FALSE(joins_when_fresh(DeviceRole::supply));
  EXPECT_EQ(cell->holds[1].action, HoldAction::end_daemon);
}

}  // namespace
}  // namespace driftwise
