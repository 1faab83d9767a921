// Any bytes: an error with file and line, or a robot that can be built, written and read back as
// the same robot.

#include <cstdint>
#include <cstdlib>

#include "server/formats/cell_file/kinematics_section.h"
#include "server/kinematics/mechanism.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto robot = formats::parse_robot_file(text, "robot.toml");
  if (!robot) {
    if (!robot.error().message.starts_with("robot.toml:")) std::abort();
    return 0;
  }
  const auto mechanism = kinematics::make_mechanism(*robot);
  if (!mechanism) std::abort();
  const std::string written = formats::write_robot_file(*robot);
  const auto again = formats::parse_robot_file(written, "robot.toml");
  if (!again || formats::write_robot_file(*again) != written) std::abort();
  const auto second = kinematics::make_mechanism(*again);
  if (!second || (*second)->parameters().size() != (*mechanism)->parameters().size()) std::abort();
  return 0;
}
