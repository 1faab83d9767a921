// One controller is driven by one process: by the address it is reached at, and by its serial
// number.

#include "drivers/pi_gcs/gcs_codec.h"
#include "drivers/pi_gcs/pi_gcs.h"
#include "tests/unit/drivers/driver_fixture.h"

namespace driftwise {
namespace {

using tests::expect;
using tests::Script;
using tests::send;

TEST(SerialNumberKey, IsModelAndNumberWhereThereIsOne) {
  EXPECT_EQ(gcs::serial_number_key("(c)2015 PI GmbH & Co. KG, C-887, 115000001, 2.1.0.3"),
            "number:C-887:115000001");
  EXPECT_EQ(gcs::serial_number_key("(c)2015 PI GmbH & Co. KG, C-887, 000, 2.1.0.3"), "");
  EXPECT_EQ(gcs::serial_number_key("C-887"), "");
  EXPECT_EQ(gcs::serial_number_key(""), "");
}

class GcsClaims : public tests::DriverFixture {
 protected:
  using Claims = std::shared_ptr<locks::Claims>;
  Result<std::unique_ptr<MotionController>> make(const std::string& address, Claims claims) {
    auto description = device("axis", "pi-gcs");
    description.address = address;
    description.become<MotionSettings>().axes.push_back({{"q1", "mm"}, "X", -2, 2, 5});
    return drivers::make_pi_gcs(description, context.get_executor(), clock, std::move(claims));
  }
  // A number of its own for each test process: these locks are the whole computer's.
  const std::string identity = "PI, C-887, " + std::to_string(getpid()) + ", 2.1\n";
  Script set_up() const {
    return {expect("*IDN?\n"), send(identity), expect("ERR?\n"), send("0\n"),
            expect("SVO?\n"),  send("X=1\n"),  expect("SAI?\n"), send("X\n"),
            expect("TMN?\n"),  send("X=-3\n"), expect("TMX?\n"), send("X=3\n"),
            expect("FRF?\n"),  send("X=1\n")};
  }
};

TEST_F(GcsClaims, RefuseTheSameAddressWithoutConnecting) {
  const auto first = make(peer.address(), std::make_shared<locks::Claims>());
  ASSERT_TRUE(first) << first.error().message;
  const auto second = make(peer.address(), std::make_shared<locks::Claims>());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().reason, "CONTROLLER_IN_USE");
  EXPECT_EQ(peer.connections(), 0);
}

TEST_F(GcsClaims, RefuseTheSameControllerAtAnotherAddressBeforeItIsToldAnything) {
  tests::ScriptedPeer other_door{context};
  peer.on_connection(set_up());
  other_door.on_connection({expect("*IDN?\n"), send(identity)});  // and not one byte more
  const auto first = make(peer.address(), std::make_shared<locks::Claims>());
  ASSERT_TRUE(run((*first)->prepare()));
  const auto second = make(other_door.address(), std::make_shared<locks::Claims>());
  ASSERT_TRUE(second) << "another address";
  const auto refused = run((*second)->prepare());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "CONTROLLER_IN_USE");
  EXPECT_THAT(other_door.problems(), testing::IsEmpty());
  EXPECT_TRUE(other_door.finished());
}

}  // namespace
}  // namespace driftwise
