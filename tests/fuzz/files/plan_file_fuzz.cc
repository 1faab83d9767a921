// Any bytes as a serving plan: an error with its place, or a plan that can be described.

#include <cstdint>
#include <cstdlib>

#include "server/formats/plan/plan_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto plan = formats::read_plan_file(text, "fuzz.toml");
  if (!plan) {
    if (!plan.error().message.starts_with("fuzz.toml:")) std::abort();
    return 0;
  }
  if (plan->robots.empty() || plan->robots.size() > plans::kMostRobots ||
      plan->steps.size() > plans::kMostSteps || plan->models().empty() ||
      plans::steps_of(*plan).empty())
    std::abort();
  return 0;
}
