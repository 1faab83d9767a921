// Any bytes: an error with a place, or a trajectory that writes and reads back to the same text.

#include <cstdint>
#include <cstdlib>

#include "server/formats/csv/trajectory_csv.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto trajectory = formats::read_trajectory_csv(text, "fuzz.csv");
  if (!trajectory) {
    if (!trajectory.error().message.starts_with("fuzz.csv:")) std::abort();
    return 0;
  }
  const std::string written = formats::write_trajectory_csv(*trajectory);
  const auto again = formats::read_trajectory_csv(written, "again.csv");
  if (!again || formats::write_trajectory_csv(*again) != written) std::abort();
  return 0;
}
