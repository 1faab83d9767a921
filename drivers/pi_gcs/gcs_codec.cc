#include "drivers/pi_gcs/gcs_codec.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "server/core/reasons.h"
#include "server/core/text/trimmed.h"
#include "server/core/try.h"

namespace driftwise::gcs {
namespace {

tl::unexpected<Error> bad_reply(std::string message) {
  return fail(ErrorCode::data_loss, reasons::kBadReply, std::move(message));
}

std::string_view trimmed(std::string_view text) { return driftwise::trimmed(text, " \r\n"); }

bool read_number(std::string_view text, double& value) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  return code == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
}

// Calls take(line) for every non-empty line, trimmed; stops and returns false when that does.
template <class Take>
bool for_each_line(std::string_view reply, Take take) {
  while (!reply.empty()) {
    const std::size_t end = reply.find('\n');
    const std::string_view line = trimmed(reply.substr(0, end));
    if (!line.empty() && !take(line)) return false;
    if (end == std::string_view::npos) break;
    reply.remove_prefix(end + 1);
  }
  return true;
}

}  // namespace

std::string encode_move(std::span<const std::string> axes, std::span<const double> mm) {
  std::string out = "MOV";
  for (std::size_t i = 0; i < axes.size(); ++i) {
    char number[32];
    const auto end = std::to_chars(number, number + sizeof number, mm[i]).ptr;
    out.append(" ").append(axes[i]).append(" ").append(number, end);
  }
  return out + "\n";
}

std::string encode_command(std::string_view command, std::span<const std::string> axes) {
  std::string out(command);
  for (const auto& axis : axes) out += " " + axis;
  return out + "\n";
}

std::string encode_switch(std::string_view command, std::span<const std::string> axes, int value) {
  std::string out(command);
  for (const auto& axis : axes) out += " " + axis + " " + std::to_string(value);
  return out + "\n";
}

Result<std::vector<double>> parse_axis_values(std::string_view reply,
                                              std::span<const std::string> axes) {
  std::vector<double> values(axes.size());
  std::vector<bool> seen(axes.size(), false);
  std::string problem;
  for_each_line(reply, [&](std::string_view line) {
    const std::size_t equals = line.find('=');
    double value = 0;
    if (equals == std::string_view::npos || !read_number(trimmed(line.substr(equals + 1)), value)) {
      problem = "expected <axis>=<number> on every line";
      return false;
    }
    for (std::size_t i = 0; i < axes.size(); ++i) {
      if (axes[i] != trimmed(line.substr(0, equals))) continue;
      if (seen[i]) problem = "axis " + axes[i] + " is there twice";
      seen[i] = true;
      values[i] = value;
    }
    return problem.empty();
  });
  if (!problem.empty()) return bad_reply(problem);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (!seen[i]) return bad_reply("no value for axis " + axes[i]);
  }
  return values;
}

Result<std::vector<bool>> parse_axis_flags(std::string_view reply,
                                           std::span<const std::string> axes) {
  DRIFTWISE_TRY(const auto values, parse_axis_values(reply, axes));
  std::vector<bool> flags;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const double value = values[i];
    if (value != 0 && value != 1)
      return bad_reply("expected " + axes[i] + "=0 or " + axes[i] + "=1");
    flags.push_back(value == 1);
  }
  return flags;
}

Result<std::vector<std::string>> parse_axis_names(std::string_view reply) {
  std::vector<std::string> names;
  const bool good = for_each_line(reply, [&](std::string_view line) {
    for (const char c : line) {
      const auto code = static_cast<unsigned char>(c);
      if (code <= 0x20 || code >= 0x7f || c == '=') return false;
    }
    names.emplace_back(line);
    return true;
  });
  if (!good || names.empty()) return bad_reply("expected one axis name per line");
  return names;
}

Result<std::uint64_t> parse_hex(std::string_view reply) {
  std::string_view text = trimmed(reply);
  if (text.starts_with("0x") || text.starts_with("0X")) text.remove_prefix(2);
  std::uint64_t value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (code != std::errc{} || end != text.data() + text.size())
    return bad_reply("expected one hexadecimal number");
  return value;
}

Result<int> parse_error_number(std::string_view reply) {
  const std::string_view text = trimmed(reply);
  int value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size())
    return bad_reply("expected one error number");
  return value;
}

std::string serial_number_key(std::string_view identity) {
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0; begin <= identity.size();) {
    const std::size_t end = std::min(identity.find(',', begin), identity.size());
    fields.push_back(trimmed(identity.substr(begin, end - begin)));
    begin = end + 1;
  }
  constexpr std::size_t kFields = 4;
  if (fields.size() < kFields) return {};
  const auto model = fields[fields.size() - 3], number = fields[fields.size() - 2];
  if (number.find_first_not_of('0') == std::string_view::npos) return {};
  return "number:" + std::string(model) + ":" + std::string(number);
}

namespace {

struct KnownError {
  int number;
  ErrorCode code;
  Reason reason;
  const char* text;
};
constexpr KnownError kErrors[] = {
    {1, ErrorCode::internal, reasons::kSyntax, "syntax error"},
    {2, ErrorCode::failed_precondition, reasons::kUnknownCommand,
     "unknown command: is the driver's option right for this controller?"},
    {kNoReferenceOrServo, ErrorCode::failed_precondition, reasons::kNotReferenced,
     "not referenced or servo off: home the axes first"},
    {7, ErrorCode::out_of_range, reasons::kPositionLimit,
     "position outside the controller's limits"},
    {8, ErrorCode::out_of_range, reasons::kVelocityLimit,
     "velocity outside the controller's limits"},
    {9, ErrorCode::failed_precondition, reasons::kPivot, "pivot cannot be set now"},
    {10, ErrorCode::aborted, reasons::kStopped, "stopped by command"},
    {15, ErrorCode::invalid_argument, reasons::kUnknownAxis,
     "unknown axis: compare device_axis in the cell file with SAI?"},
    {17, ErrorCode::out_of_range, reasons::kParameterRange, "parameter out of range"},
    {24, ErrorCode::internal, reasons::kParameterCount, "wrong number of parameters"},
    {26, ErrorCode::internal, reasons::kParameterMissing, "parameter missing"},
    {216, ErrorCode::failed_precondition, reasons::kRefused, "an axis is on a limit switch"},
    {1024, ErrorCode::failed_precondition, reasons::kRefused,
     "motion error: the position error became too large"},
};

const KnownError* find(int number) {
  for (const auto& error : kErrors)
    if (error.number == number) return &error;
  return nullptr;
}

}  // namespace

std::string describe_error(int number) {
  const KnownError* known = find(number);
  return std::to_string(number) + " (" + (known ? known->text : "see the controller's manual") +
         ")";
}

Error refusal(int number, std::string_view command) {
  const KnownError* known = find(number);
  return {known ? known->code : ErrorCode::failed_precondition,
          known ? known->reason : reasons::kRefused,
          "controller refused " + std::string(command) + " with error " + describe_error(number)};
}

}  // namespace driftwise::gcs
