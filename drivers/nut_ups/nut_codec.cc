#include "drivers/nut_ups/nut_codec.h"

#include <cmath>
#include <utility>

#include "drivers/transport/framing.h"
#include "drivers/transport/words.h"
#include "server/core/reasons.h"

namespace driftwise::nut_ups {
namespace {

tl::unexpected<Error> bad_nut_reply(const std::string& expected) {
  return fail(ErrorCode::data_loss, reasons::kBadReply, "expected " + expected);
}

Error refusal_of(std::string_view word, std::string_view ups) {
  const std::string name(ups), said(word);
  if (word.starts_with("UNKNOWN-UPS"))
    return {ErrorCode::failed_precondition, reasons::kUpsNotThere,
            "upsd knows no '" + name + "' (" + said +
                "): 'upsc -l' lists those there are; option ups names one"};
  if (word.starts_with("ACCESS-DENIED"))
    return {ErrorCode::failed_precondition, reasons::kAccessDenied,
            "upsd refuses this computer (" + said + "): look at upsd.conf"};
  return {ErrorCode::failed_precondition, reasons::kUpsStale,
          "upsd has no present data of '" + name + "' (" + said +
              "): look at the UPS driver (upsdrvctl) and its cable"};
}

}  // namespace

bool is_version(std::string_view line) { return line.starts_with("Network UPS Tools"); }

std::string get_command(std::string_view ups, std::string_view name) {
  return "GET VAR " + std::string(ups) + " " + std::string(name);
}

Result<std::optional<std::string>> parse_value(std::string_view reply, std::string_view ups,
                                               std::string_view name) {
  const std::string_view line = transport::without_line_ends(reply);
  if (line.starts_with("ERR ")) {
    const std::string_view word = line.substr(4);
    if (word.starts_with("VAR-NOT-SUPPORTED")) return std::optional<std::string>();
    return tl::unexpected(refusal_of(word, ups));
  }
  const std::string front = "VAR " + std::string(ups) + " " + std::string(name) + " \"";
  if (!line.starts_with(front) || !line.ends_with('"') || line.size() <= front.size())
    return bad_nut_reply(front + "<value>\"");
  return std::optional(std::string(line.substr(front.size(), line.size() - front.size() - 1)));
}

Result<Supply> parse_status(std::string_view status) {
  if (status == "WAIT")
    return fail(ErrorCode::failed_precondition, reasons::kUpsStale,
                "upsd waits for its UPS driver (upsdrvctl)");
  Supply supply;
  bool says_where = false, low = false, calibrates = false;
  while (!status.empty()) {
    const std::size_t end = std::min(status.find(' '), status.size());
    const std::string_view word = status.substr(0, end);
    status.remove_prefix(std::min(end + 1, status.size()));
    says_where = says_where || word == "OL" || word == "OB" || word == "FSD" || word == "BYPASS";
    supply.on_mains = supply.on_mains || word == "OL";
    supply.on_battery = supply.on_battery || word == "OB";
    low = low || word == "LB";
    calibrates = calibrates || word == "CAL";
    supply.forced = supply.forced || word == "FSD";
  }
  if (!says_where) return bad_nut_reply("OL or OB among the words of ups.status");
  supply.low_battery = low && supply.on_battery && !calibrates;
  return supply;
}

bool AboutToGo::take(const Supply& supply) {
  const bool is_first = !std::exchange(seen_, true);
  is_old_ = supply.forced && (is_first || is_old_);
  const bool ends = supply.forced && !(is_old_ && supply.on_mains);
  return supply.low_battery || ends;
}

Result<double> parse_quantity(std::string_view text, std::string_view name) {
  double value = 0;
  if (!transport::read_number(text, value) || !std::isfinite(value) || value < 0)
    return bad_nut_reply("a number from 0 up for " + std::string(name));
  return value;
}

}  // namespace driftwise::nut_ups
