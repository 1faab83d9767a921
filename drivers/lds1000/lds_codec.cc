#include "drivers/lds1000/lds_codec.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "drivers/transport/framing.h"
#include "drivers/transport/words.h"
#include "server/core/reasons.h"
#include "server/core/units.h"

namespace driftwise::lds1000 {
namespace {

tl::unexpected<Error> no_reply_to(const std::string& command, const std::string& expected) {
  return fail(ErrorCode::data_loss, reasons::kBadReply,
              "no answer to " + command + ": expected " + expected);
}

// What follows the repeated command; nothing when another command was answered.
std::optional<std::string_view> after_command(std::string_view reply, std::string_view command) {
  reply = transport::without_line_ends(reply);
  while (reply.ends_with(' ')) reply.remove_suffix(1);
  while (reply.starts_with(' ')) reply.remove_prefix(1);
  if (!reply.starts_with(command)) return std::nullopt;
  return reply.substr(command.size());
}

std::vector<std::string_view> fields_of(std::string_view text) {
  std::vector<std::string_view> out;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    out.push_back(text.substr(from, comma - from));
    from = comma + 1;
  }
  return out;
}

std::optional<Unit> unit_from(std::string_view text) {
  if (text == "sec") return Unit::arcsec;
  if (!text.ends_with("rad")) return std::nullopt;
  const auto prefix = text.substr(0, text.size() - 3);
  // One byte in the device's own code page, or two where a terminal server made UTF-8 of it.
  if (prefix == "\xB5" || prefix == "\xE6" || prefix == "\xC2\xB5" || prefix == "\xCE\xBC" ||
      prefix == "u")
    return Unit::microradian;
  return std::nullopt;
}

// "0.2", or "0,2" that the separator has cut in two.
std::optional<double> increment_from(const std::vector<std::string_view>& fields, std::size_t first,
                                     std::size_t end) {
  if (end - first != 1 && end - first != 2) return std::nullopt;
  std::string text(fields[first]);
  if (end - first == 2) text += "." + std::string(fields[first + 1]);
  double value = 0;
  if (!transport::read_number(text, value) || !std::isfinite(value) || value <= 0)
    return std::nullopt;
  return value;
}

}  // namespace

const char* name_of(Unit unit) { return unit == Unit::arcsec ? "sec" : "urad"; }

double arcsec_from(double value, Unit unit) {
  return unit == Unit::arcsec ? value : arcsec_from_rad(value * 1e-6);
}

Result<std::string> parse_version(std::string_view reply) {
  const auto rest = after_command(reply, "VE");
  if (!rest || rest->size() < 2 || rest->front() != ' ' ||
      rest->find("LDS1000") == std::string_view::npos)
    return no_reply_to("VE", "VE LDS1000 ...");
  return std::string(rest->substr(1));
}

Result<SetUp> parse_set_up(std::string_view reply, int axis) {
  const std::string command = std::to_string(axis) + "TA";
  const auto rest = after_command(reply, command);
  const auto bad = [&] {
    return no_reply_to(command, command + ",<type>,<coefficient>,<increment>,<unit>,<o1>,<o2>");
  };
  if (!rest) return bad();
  // "", type, coefficient | increment, perhaps in two | unit, offset, offset
  const auto fields = fields_of(*rest);
  constexpr std::size_t kFront = 3, kBack = 3;
  if (fields.size() <= kFront + kBack || !fields.front().empty()) return bad();
  const auto increment = increment_from(fields, kFront, fields.size() - kBack);
  if (!increment) return bad();
  const auto unit = unit_from(fields[fields.size() - kBack]);
  if (!unit)
    return fail(ErrorCode::failed_precondition, reasons::kUnknownUnit,
                "axis " + std::to_string(axis) +
                    " is set up in neither sec nor microradian: set its unit on the controller");
  return SetUp{*unit, *increment};
}

Result<double> parse_value(std::string_view reply, int axis) {
  const std::string command = std::to_string(axis) + "TP";
  const auto rest = after_command(reply, command);
  double value = 0;
  if (!rest || !transport::read_number(*rest, value) || !std::isfinite(value))
    return no_reply_to(command, command + "<number>");
  return value;
}

Result<Status> parse_status(std::string_view reply) {
  const auto rest = after_command(reply, "MS");
  if (!rest || rest->size() != 1 || (rest->front() & 0x40) == 0)
    return no_reply_to("MS", "MS and one status character");
  const auto bits = static_cast<unsigned char>(rest->front());
  return Status{(bits & 0x01) != 0, (bits & 0x02) != 0};
}

Result<int> parse_integration_ms(std::string_view reply) {
  const auto rest = after_command(reply, "XI");
  int value = 0;
  if (!rest || !transport::read_number(*rest, value) || value < 0)
    return no_reply_to("XI", "XI<ms>");
  return value;
}

Result<void> parse_error(std::string_view reply) {
  const auto rest = after_command(reply, "TE");
  if (!rest || rest->size() != 1) return no_reply_to("TE", "TE and one error character");
  switch (rest->front()) {
    case '@':
      return {};
    case 'A':
      return fail(ErrorCode::internal, reasons::kUnknownCommand, "the controller does not know it");
    case 'B':
      return fail(ErrorCode::invalid_argument, reasons::kBadAxis,
                  "the controller has no such axis");
    case 'C':
    case 'O':
      return fail(ErrorCode::invalid_argument, reasons::kBadParameter,
                  "the value is outside the controller's limits");
    case 'D':
      return fail(ErrorCode::failed_precondition, reasons::kNotNow,
                  "the controller does not allow it now: end its acquisition or its menu first");
    case 'S':
      return fail(ErrorCode::deadline_exceeded, reasons::kDeviceTimeout,
                  "the controller timed out");
    default:
      return no_reply_to("TE", "one of @ A B C D O S");
  }
}

}  // namespace driftwise::lds1000
