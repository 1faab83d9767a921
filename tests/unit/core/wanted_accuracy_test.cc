#include "server/core/records/wanted_accuracy.h"

#include <gmock/gmock.h>

namespace driftwise {
namespace {

using testing::HasSubstr;

TEST(WantedAccuracy, IsOfACoordinateOrOfAUnit) {
  EXPECT_EQ(*wanted_accuracy_from({"wanted_a90.x_nm", "100"}), (WantedAccuracy{"x", "nm", 100}));
  EXPECT_EQ(*wanted_accuracy_from({"wanted_a90_nm", "100"}), (WantedAccuracy{"", "nm", 100}));
  EXPECT_EQ(*wanted_accuracy_from({"wanted_a90.ma.rx_arcsec", "2.5"}),
            (WantedAccuracy{"ma.rx", "arcsec", 2.5}));
}

TEST(WantedAccuracy, MayComeInAnotherUnitOfItsKind) {
  const auto wanted = wanted_accuracy_from({"wanted_a90.z_um", "0.25"});
  ASSERT_TRUE(wanted);
  EXPECT_EQ(wanted->unit, "nm");
  EXPECT_DOUBLE_EQ(wanted->a90, 250);
}

TEST(WantedAccuracy, OfNoCoordinateNoUnitOrNoNumberIsRefusedWithWhatIsExpected) {
  for (const auto& [key, value, expected] :
       {std::tuple{"wanted_a90.t07_degC", "1", "a coordinate of the pose"},
        {"wanted_a90.x", "100", "a coordinate of the pose"},
        {"wanted_a90_K", "1", "a unit of length or angle"},
        {"wanted_a90.x_nm", "abc", "a number above 0"},
        {"wanted_a90_nm", "-5", "a number above 0"},
        {"wanted_a90_nm", "100 nm", "a number above 0"}}) {
    const auto wanted = wanted_accuracy_from({key, value});
    ASSERT_FALSE(wanted) << key << "=" << value;
    EXPECT_EQ(wanted.error().reason, "BAD_METADATA");
    EXPECT_THAT(wanted.error().message, HasSubstr(expected));
  }
}

TEST(WantedAccuracy, ThatSaysNoneIsNoMetadataOfARun) {
  EXPECT_FALSE(checked_metadata({{"wanted_a90.x_nm", "soon"}}));
  EXPECT_TRUE(checked_metadata({{"wanted_a90.x_nm", "80"}, {"sample", "A12"}}));
}

TEST(WantedAccuracy, OfACoordinateGoesBeforeThatOfItsUnit) {
  const std::vector<WantedAccuracy> wanted{{"", "nm", 100}, {"z", "nm", 300}, {"rx", "arcsec", 2}};
  EXPECT_EQ(wanted_of(wanted, "x", "nm")->a90, 100);
  EXPECT_EQ(wanted_of(wanted, "z", "nm")->a90, 300);
  EXPECT_EQ(wanted_of(wanted, "rx", "arcsec")->a90, 2);
  EXPECT_EQ(wanted_of(wanted, "ry", "arcsec"), nullptr);
}

TEST(WantedAccuracy, OfAMotorIsTheStrictestOfTheCoordinatesThatItMayCarry) {
  const std::vector<WantedAccuracy> wanted{{"x", "nm", 100}, {"z", "nm", 300}};
  EXPECT_EQ(wanted_of(wanted, "q1", "nm")->a90, 100);
  EXPECT_EQ(wanted_of(wanted, "y", "nm"), nullptr);
  const std::vector<WantedAccuracy> two{{"mn.x", "nm", 100}, {"ma.z", "nm", 500}};
  EXPECT_EQ(wanted_of(two, "ma.q1", "nm")->a90, 500);
}

TEST(WantedAccuracy, OfTwoRunsIsTheSmaller) {
  std::vector<WantedAccuracy> wanted;
  add_wanted(wanted, {"x", "nm", 100});
  add_wanted(wanted, {"x", "nm", 60});
  add_wanted(wanted, {"x", "nm", 80});
  EXPECT_EQ(wanted_text(wanted), "x 60 nm");
}

}  // namespace
}  // namespace driftwise
