#include "server/access/proof_ends.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace driftwise::access {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::int64_t kProofDay = 86'400, kProofNow = 20'000 * kProofDay;  // 2024-10-04

ProofEnd token_for(const std::string& id, double begins_in_days, double ends_in_days) {
  const auto at = [](double days) {
    return kProofNow + static_cast<std::int64_t>(days * kProofDay);
  };
  return {"token " + id, "press", Role::controller, at(begins_in_days), at(ends_in_days)};
}

std::vector<std::string> subjects_of(const std::vector<ProofEnd>& proofs) {
  std::vector<std::string> out;
  for (const auto& one : ending(proofs, kProofNow)) out.push_back(one.subject);
  return out;
}

TEST(ProofEnds, AreSpokenOfThirtyDaysBeforeAndAWeekAfter) {
  EXPECT_THAT(subjects_of({token_for("a", -335, 31)}), IsEmpty());
  EXPECT_THAT(subjects_of({token_for("a", -335, 29)}), ElementsAre("token a"));
  EXPECT_THAT(subjects_of({token_for("a", -370, -6)}), ElementsAre("token a"));
  EXPECT_THAT(subjects_of({token_for("a", -370, -8)}), IsEmpty());
}

TEST(ProofEnds, OfAShortTokenAreSpokenOfInItsLastThird) {
  EXPECT_THAT(subjects_of({token_for("a", 0, 1)}), IsEmpty());
  EXPECT_THAT(subjects_of({token_for("a", -0.7, 0.3)}), ElementsAre("token a"));
}

TEST(ProofEnds, AreOverWhenALaterProofOfTheSameNameAndRoleIsThere) {
  EXPECT_THAT(subjects_of({token_for("a", -360, 5), token_for("b", 0, 365)}), IsEmpty());
  auto viewer = token_for("b", 0, 365);
  viewer.role = Role::viewer;
  EXPECT_THAT(subjects_of({token_for("a", -360, 5), viewer}), ElementsAre("token a"));
  auto certificate = token_for("b", 0, 365);
  certificate.subject = "certificate of press";
  EXPECT_THAT(subjects_of({token_for("a", -360, 5), certificate}), ElementsAre("token a"));
}

TEST(ProofEnds, SayWhenWhoseAndWhatToDo) {
  EXPECT_EQ(ending({token_for("k3f9a2c1", -360, 5)}, kProofNow).at(0).message,
            "the token k3f9a2c1 of press (controller) ends on 2024-10-09, in 5 days: from then on "
            "calls with it are refused. Make another one (driftwise token create press --role "
            "controller) and put it in its place");
  EXPECT_THAT(ending({token_for("k3f9a2c1", -360, -1)}, kProofNow).at(0).message,
              HasSubstr("has ended on 2024-10-03: calls with it are refused"));
}

}  // namespace
}  // namespace driftwise::access
