#include "drivers/load_actuator/load_codec.h"

#include <charconv>
#include <cmath>

#include "drivers/transport/words.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::load_actuator {
namespace {

tl::unexpected<Error> bad_load_reply(std::string message) {
  return fail(ErrorCode::data_loss, reasons::kBadReply, std::move(message));
}

std::string joined(const std::vector<std::string_view>& words, std::size_t first) {
  std::string out;
  for (std::size_t i = first; i < words.size(); ++i)
    out += (out.empty() ? "" : " ") + std::string(words[i]);
  return out;
}

Error refusal(int code, const std::string& text) {
  const std::string said = text.empty() ? std::string() : " (" + text + ")";
  switch (code) {
    case 1:
      return {ErrorCode::internal, reasons::kSyntax,
              "the actuator does not understand the request" + said};
    case 2:
      return {ErrorCode::out_of_range, reasons::kNoSuchLoad,
              "the actuator's weights do not give this force" + said};
    case 3:
      return {ErrorCode::failed_precondition, reasons::kLoadBusy,
              "the actuator still moves its weights" + said};
    case 4:
      return {ErrorCode::failed_precondition, reasons::kLoadJammed,
              "the actuator is jammed: look at its pan and pulleys" + said};
    default:
      return {ErrorCode::failed_precondition, reasons::kRefused, "the actuator refuses" + said};
  }
}

// The words after "OK".
Result<std::vector<std::string_view>> taken(std::string_view reply) {
  auto words = transport::words_of(reply);
  if (!words.empty() && words[0] == "OK") {
    words.erase(words.begin());
    return words;
  }
  int code = 0;
  if (words.size() >= 2 && words[0] == "ERR" && transport::read_number(words[1], code))
    return tl::unexpected(refusal(code, joined(words, 2)));
  return bad_load_reply("expected OK ... or ERR <code> <text>");
}

}  // namespace

Result<std::string> parse_identity(std::string_view reply) {
  DRIFTWISE_TRY(const auto words, taken(reply));
  if (words.size() < 3) return bad_load_reply("expected OK <maker> <model> <serial>");
  return joined(words, 0);
}

Result<Load> parse_load(std::string_view reply) {
  DRIFTWISE_TRY(const auto words, taken(reply));
  Load out;
  int resting = 0;
  if (words.size() != 2 || !transport::read_number(words[0], out.force_n) ||
      !std::isfinite(out.force_n) || !transport::read_number(words[1], resting) ||
      (resting != 0 && resting != 1))
    return bad_load_reply("expected OK <newton> <resting 1|0>");
  out.resting = resting == 1;
  return out;
}

Result<void> parse_ok(std::string_view reply) {
  DRIFTWISE_TRY(const auto words, taken(reply));
  if (!words.empty()) return bad_load_reply("expected OK alone");
  return {};
}

std::string load_command(double force_n) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, force_n).ptr;
  return "LOAD " + std::string(digits, end);
}

}  // namespace driftwise::load_actuator
