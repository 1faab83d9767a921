#include "drivers/touch_probe/nd28x_codec.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <vector>

#include "drivers/transport/words.h"
#include "server/core/reasons.h"
#include "server/core/text/trimmed.h"

namespace driftwise::touch_probe {
namespace {

constexpr char kStartOfText = '\x02';
constexpr double kLargest_mm = 1000;  // no probe of this kind is longer

tl::unexpected<Error> bad_nd28x_reply(const char* expected) {
  return fail(ErrorCode::data_loss, reasons::kBadReply, std::string("expected ") + expected);
}

std::string_view trimmed(std::string_view text) { return driftwise::trimmed(text, " \r\n\x02"); }

bool is_printable(std::string_view text) {
  return std::ranges::all_of(text, [](unsigned char c) { return c >= ' ' && c < 0x7f; });
}

}  // namespace

Result<double> parse_value(std::string_view reply) {
  constexpr const char* kExpected = "<sign> <millimetres> <unit mark>";
  std::string_view text = trimmed(reply);
  if (text.empty() || !is_printable(text)) return bad_nd28x_reply(kExpected);
  const bool has_digit = std::ranges::any_of(text, [](unsigned char c) { return std::isdigit(c); });
  const bool begins_as_value = text.front() == '+' || text.front() == '-';
  if (!has_digit && !begins_as_value)
    return fail(ErrorCode::failed_precondition, reasons::kInputError,
                "the read-out shows '" + std::string(text) +
                    "' in the place of a value: look at the probe's cable, clear the message");
  if (!begins_as_value) return bad_nd28x_reply(kExpected);
  const bool is_negative = text.front() == '-';
  text = trimmed(text.substr(1));
  if (text.ends_with('"'))
    return fail(ErrorCode::failed_precondition, reasons::kWrongSetUp,
                "the read-out shows inches: set it to millimetres");
  double value_mm = 0;
  if (text.starts_with('+') || text.starts_with('-') || !transport::read_number(text, value_mm) ||
      !std::isfinite(value_mm) || value_mm > kLargest_mm)
    return bad_nd28x_reply(kExpected);
  return is_negative ? -value_mm : value_mm;
}

Result<std::string> parse_identity(std::string_view reply) {
  std::vector<std::string_view> lines;
  for (std::string_view rest = reply; !rest.empty();) {
    const auto end = std::min(rest.find_first_of("\r\n"), rest.size());
    if (const auto line = trimmed(rest.substr(0, end)); !line.empty()) lines.push_back(line);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  if (lines.size() != kIdentityLines || reply.find(kStartOfText) >= reply.find(lines[0]) ||
      !std::ranges::all_of(lines, is_printable))
    return bad_nd28x_reply("STX and three lines of identity");
  if (!lines[0].starts_with("ND"))
    return fail(ErrorCode::failed_precondition, reasons::kWrongDevice,
                "expected a Heidenhain ND read-out");
  return std::string(lines[0]) + ", " + std::string(lines[1]) + ", " + std::string(lines[2]);
}

}  // namespace driftwise::touch_probe
