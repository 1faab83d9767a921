#include <gtest/gtest.h>

#include "server/effects/effect.h"
#include "server/effects/term_order.h"

namespace driftwise::effects {
namespace {

TEST(Notation, OfTheConstantIsOne) { EXPECT_EQ(notation(Term{}), "1"); }

TEST(Notation, MergesPowersAndOrdersFactors) {
  const Term term{{Power{"t07", 1}, Power{"x", 1}, Power{"force", 1}, Power{"x", 2}}};
  EXPECT_EQ(notation(term), "x^3:force:t07");
}

TEST(Notation, CountsNumberedSymbolsAsNumbers) {
  EXPECT_EQ(notation(Term{{Power{"t10", 1}, Power{"t2", 1}}}), "t2:t10");
}

TEST(Notation, OfAnEffectCarriesItsQuantities) {
  EXPECT_EQ(notation(Term{{Call{"rate", {"t07"}, {{300, "s"}}}}}), "rate(t07, 300 s)");
  EXPECT_EQ(notation(datum_term(2)), "datum(2)");
}

TEST(Term, EqualUpToOrderIsOneColumn) {
  EXPECT_EQ(canonical({{Power{"y", 1}, Power{"x", 1}}}),
            canonical({{Power{"x", 1}, Power{"y", 1}}}));
  EXPECT_EQ(product({{Power{"x", 1}}}, {{Power{"x", 2}}}), (Term{{Power{"x", 3}}}));
}

TEST(Checked, BringsParametersToTheirUnit) {
  const auto call = checked({"lag", {"t07"}, {{30.5, "min"}}});
  ASSERT_TRUE(call.has_value());
  EXPECT_EQ(notation(Factor(*call)), "lag(t07, 1830 s)");
}

TEST(Checked, SaysWhatAnEffectExpects) {
  EXPECT_NE(checked({"lag", {"t07"}, {}}).error().message.find("expected lag(channel, tau s)"),
            std::string::npos);
  EXPECT_NE(
      checked({"lag", {"t07"}, {{300, "nm"}}}).error().message.find("tau is in 'nm', expected s"),
      std::string::npos);
  EXPECT_NE(checked({"lag", {"t07"}, {{0, "s"}}}).error().message.find("expected 1 to 1e+06 s"),
            std::string::npos);
  EXPECT_EQ(checked({"wobble", {"t07"}, {}}).error().reason, "UNKNOWN_EFFECT");
}

}  // namespace
}  // namespace driftwise::effects
