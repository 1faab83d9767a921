#include "drivers/inclinometer/dpl_codec.h"

#include <cmath>
#include <optional>
#include <vector>

#include "drivers/transport/framing.h"
#include "drivers/transport/words.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::inclinometer {
namespace {

constexpr double kLargest_deg = 360;

tl::unexpected<Error> bad_dpl_reply(const std::string& expected) {
  return fail(ErrorCode::data_loss, reasons::kBadReply, "expected " + expected);
}

// Lines without their ends, empty ones and the echo of the stop left out.
std::vector<std::string_view> lines_of(std::string_view reply) {
  std::vector<std::string_view> lines;
  while (!reply.empty()) {
    const std::size_t end = std::min(reply.find_first_of("\r\n"), reply.size());
    std::string_view line = reply.substr(0, end);
    reply.remove_prefix(std::min(end + 1, reply.size()));
    while (line.starts_with('s')) line.remove_prefix(1);
    if (!line.empty()) lines.push_back(line);
  }
  return lines;
}

// The number of "X=+01.234".
std::optional<double> value_of(std::string_view line, std::string_view name) {
  double value = 0;
  if (!line.starts_with(name)) return std::nullopt;
  line.remove_prefix(name.size());
  if (line.starts_with('+')) line.remove_prefix(1);
  if (line.starts_with('+') || !transport::read_number(line, value)) return std::nullopt;
  if (!std::isfinite(value) || std::abs(value) > kLargest_deg) return std::nullopt;
  return value;
}

}  // namespace

bool ends_identity(std::string_view line) { return line.starts_with("SN:"); }

Result<std::string> parse_identity(std::string_view reply) {
  const auto lines = lines_of(reply);
  if (lines.size() != 2 || !ends_identity(lines[1]))
    return bad_dpl_reply("<model> <version> and SN:<number>, a line each");
  if (!lines[0].starts_with("DP"))
    return fail(ErrorCode::failed_precondition, reasons::kWrongDevice,
                "expected a MEAS DPL or DPG inclinometer");
  return std::string(lines[0]) + ", " + std::string(lines[1]);
}

Result<Tilt> parse_tilt(std::string_view reply) {
  const auto lines = lines_of(reply);
  if (lines.size() != 2) return bad_dpl_reply("X=<degrees> and Y=<degrees>, a line each");
  const auto x = value_of(lines[0], "X="), y = value_of(lines[1], "Y=");
  if (!x || !y) return bad_dpl_reply("X=<degrees> and Y=<degrees>, a line each");
  return Tilt{*x, *y};
}

}  // namespace driftwise::inclinometer
