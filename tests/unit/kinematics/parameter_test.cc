#include "server/kinematics/parameter.h"

#include <gtest/gtest.h>

namespace driftwise::kinematics {
namespace {

Parameters some() {
  return {{"link1.d_mm", 1}, {"link1.beta_deg", 2}, {"link2.beta_deg", 3}, {"frame.x_mm", 4}};
}

std::string held_names(const Parameters& parameters) {
  std::string text;
  for (const auto& parameter : parameters)
    if (parameter.held) text += parameter.name + " ";
  return text;
}

TEST(HeldParameters, AreNamedOrMatched) {
  for (const auto& [pattern, expected] : std::vector<std::pair<std::string, std::string>>{
           {"link1.d_mm", "link1.d_mm "},
           {"*.beta_deg", "link1.beta_deg link2.beta_deg "},
           {"frame.*", "frame.x_mm "},
           {"*", "link1.d_mm link1.beta_deg link2.beta_deg frame.x_mm "},
           {"link*.*_deg", "link1.beta_deg link2.beta_deg "}}) {
    Parameters parameters = some();
    ASSERT_TRUE(hold(parameters, {pattern}));
    EXPECT_EQ(held_names(parameters), expected) << pattern;
  }
}

TEST(HeldParameters, ThatDoNotExistAreAnErrorThatListsThem) {
  Parameters parameters = some();
  const auto held = hold(parameters, {"link3.*"});
  ASSERT_FALSE(held);
  EXPECT_EQ(held.error().reason, "UNKNOWN_PARAMETER");
  EXPECT_NE(held.error().message.find("link2.beta_deg"), std::string::npos);
}

TEST(HeldParameters, TakeALongChainOfStarsInNoTime) {
  Parameters parameters = some();
  EXPECT_FALSE(hold(parameters, {std::string(5000, '*') + "b*b*b*b*b*b*b*!"}));
}

}  // namespace
}  // namespace driftwise::kinematics
