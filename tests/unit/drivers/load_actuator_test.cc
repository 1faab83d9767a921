#include "drivers/load_actuator/load_actuator.h"

#include <random>

#include "drivers/load_actuator/load_codec.h"
#include "tests/unit/drivers/driver_fixture.h"

namespace driftwise {
namespace {

using testing::HasSubstr;
using tests::expect;
using tests::Script;
using tests::send;

TEST(LoadCodec, ReadsForceAndRest) {
  const auto load = load_actuator::parse_load("OK 2.305 0\n");
  ASSERT_TRUE(load);
  EXPECT_EQ(load->force_n, 2.305);
  EXPECT_FALSE(load->resting);
  for (const char* bad : {"", "OK", "OK 2.305", "OK 2.305 2", "OK nan 1", "OK 1 1 1", "2.305 1"})
    EXPECT_EQ(load_actuator::parse_load(bad).error().reason, "BAD_REPLY") << bad;
}

TEST(LoadCodec, PassesRefusalsOnWithTheDevicesWords) {
  EXPECT_EQ(load_actuator::parse_ok("ERR 2 no such weight\n").error().code,
            ErrorCode::out_of_range);
  EXPECT_THAT(load_actuator::parse_ok("ERR 4 pan caught\n").error().message,
              HasSubstr("pan caught"));
  EXPECT_EQ(load_actuator::parse_ok("ERR 9 what").error().reason, "REFUSED");
  EXPECT_EQ(load_actuator::parse_ok("OK 2.3 1").error().reason, "BAD_REPLY");
}

TEST(LoadCodec, WritesAForceThatReadsBackExactly) {
  EXPECT_EQ(load_actuator::load_command(2.305), "LOAD 2.305");
  EXPECT_EQ(load_actuator::load_command(0), "LOAD 0");
}

TEST(LoadCodec, SurvivesAnythingOnTheLine) {
  std::mt19937 random(20110722);
  const std::string alphabet = "OKERLAD? 0123456789.-+einf\r\n\t";
  for (int i = 0; i < 20'000; ++i) {
    std::string reply = random() % 2 ? "OK " : "ERR ";
    for (auto n = random() % 24; n > 0; --n) reply += alphabet[random() % alphabet.size()];
    EXPECT_TRUE(
        std::isfinite(load_actuator::parse_load(reply).value_or(load_actuator::Load{}).force_n));
    (void)load_actuator::parse_ok(reply);
    (void)load_actuator::parse_identity(reply);
  }
}

class LoadActuatorLoop : public tests::DriverFixture {
 protected:
  LoadActuator& make() {
    auto description = device("load", "load-actuator");
    description.become<LoadSettings>().force = {"force", "N"};
    auto made = drivers::make_load_actuator(description, context.get_executor(), clock);
    EXPECT_TRUE(made) << made.error().message;
    actuator = std::move(*made);
    return *actuator;
  }
  static Script identified_and(const Script& rest) {
    Script out{expect("IDN?\n"), send("OK Driftwise weights 0001\n")};
    out.insert(out.end(), rest.begin(), rest.end());
    return out;
  }
  std::unique_ptr<LoadActuator> actuator;
};

TEST_F(LoadActuatorLoop, SetsAForceAndSaysWhenItRests) {
  peer.on_connection(identified_and({expect("LOAD 2.305\n"), send("OK\n"), expect("LOAD?\n"),
                                     send("OK 0 0\n"), expect("LOAD?\n"), send("OK 2.305 1\n")}));
  ASSERT_TRUE(run(make().set_force(2.305)));
  EXPECT_FALSE(run(actuator->state())->resting);
  const auto there = run(actuator->state());
  EXPECT_TRUE(there->resting);
  EXPECT_EQ(there->force_n, 2.305);
  EXPECT_EQ(actuator->health().identity, "Driftwise weights 0001");
}

TEST_F(LoadActuatorLoop, PassesARefusalOnAndStaysConnected) {
  peer.on_connection(identified_and(
      {expect("LOAD 9\n"), send("ERR 2 largest is 4\n"), expect("LOAD?\n"), send("OK 0 1\n")}));
  const auto refused = run(make().set_force(9));
  EXPECT_EQ(refused.error().reason, "NO_SUCH_LOAD");
  EXPECT_THAT(refused.error().message, HasSubstr("largest is 4"));
  EXPECT_TRUE(run(actuator->state()));
  EXPECT_EQ(actuator->health().reconnects, 0);
}

TEST_F(LoadActuatorLoop, RefusesWhatIsNoActuator) {
  peer.on_connection({expect("IDN?\n"), send("KEITHLEY INSTRUMENTS\n")});
  EXPECT_EQ(run(make().state()).error().reason, "BAD_REPLY");
}

}  // namespace
}  // namespace driftwise
