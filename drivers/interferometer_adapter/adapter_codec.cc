#include "drivers/interferometer_adapter/adapter_codec.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <vector>

#include "drivers/transport/words.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::adapter {
namespace {

using transport::read_number;
using transport::words_of;

tl::unexpected<Error> bad_reply(std::string message) {
  return fail(ErrorCode::data_loss, reasons::kBadReply, std::move(message));
}

bool read_hex(std::string_view text, std::uint32_t& value) {
  if (!text.starts_with("0x") && !text.starts_with("0X")) return false;
  text.remove_prefix(2);
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  return code == std::errc{} && end == text.data() + text.size();
}

Error device_error(int code) {
  switch (code) {
    case 1:
      return {ErrorCode::internal, reasons::kSyntax, "the adapter does not understand the request"};
    case 2:
      return {ErrorCode::failed_precondition, reasons::kNoDevice,
              "the adapter sees no interferometer on this channel: check its USB cable and the "
              "option 'channel'"};
    case 3:
      return {ErrorCode::failed_precondition, reasons::kBeamLost,
              "the beam was interrupted, the length is lost: free the beam and zero again"};
    case 4:
      return {ErrorCode::deadline_exceeded, reasons::kDeviceTimeout,
              "the interferometer does not answer the adapter"};
    case 5:
      return {ErrorCode::data_loss, reasons::kValuesLost, "the adapter lost values (overflow)"};
    case 6:
      return {ErrorCode::failed_precondition, reasons::kLaserUnstable,
              "the laser is not stable: let it warm up"};
    default:
      return {ErrorCode::failed_precondition, reasons::kRefused, "the adapter refuses"};
  }
}

// The words after "OK".
Result<std::vector<std::string_view>> accepted(std::string_view reply) {
  auto words = words_of(reply);
  if (!words.empty() && words[0] == "OK") {
    words.erase(words.begin());
    return words;
  }
  int code = 0;
  if (words.size() >= 2 && words[0] == "ERR" && read_number(words[1], code))
    return tl::unexpected(device_error(code));
  return bad_reply("expected OK ... or ERR <code> <text>");
}

std::optional<std::string_view> field(const std::vector<std::string_view>& words,
                                      std::string_view name) {
  for (const auto word : words) {
    if (word.size() > name.size() && word.starts_with(name) && word[name.size()] == '=')
      return word.substr(name.size() + 1);
  }
  return std::nullopt;
}

}  // namespace

std::optional<CellTime> parse_unix_time(std::string_view text) {
  const std::size_t point = text.find('.');
  std::int64_t seconds = 0;
  // 1970 .. 2262 is what 64 bits of nanoseconds hold.
  if (!read_number(text.substr(0, point), seconds) || seconds < 0 || seconds > 9'223'372'035)
    return std::nullopt;
  std::int64_t nanoseconds = 0;
  if (point != std::string_view::npos) {
    const std::string_view digits = text.substr(point + 1);
    if (digits.empty() || digits.find_first_not_of("0123456789") != std::string_view::npos)
      return std::nullopt;
    for (std::size_t i = 0; i < 9; ++i)
      nanoseconds = nanoseconds * 10 + (i < digits.size() ? digits[i] - '0' : 0);
  }
  return CellTime{seconds * 1'000'000'000 + nanoseconds};
}

Result<Identity> parse_identity(std::string_view reply) {
  DRIFTWISE_TRY(const auto words, accepted(reply));
  Identity out;
  const auto channels = field(words, "ch");
  if (!channels || !read_number(*channels, out.channels) || out.channels < 1)
    return bad_reply("expected OK <maker> <model> <serial> ch=<count>");
  for (const auto word : words) {
    if (word.starts_with("ch=")) continue;
    if (!out.text.empty()) out.text += ' ';
    out.text += word;
  }
  if (out.text.empty()) return bad_reply("expected maker, model and serial before ch=");
  return out;
}

Result<void> parse_ok(std::string_view reply) {
  DRIFTWISE_TRY(const auto words, accepted(reply));
  if (!words.empty()) return bad_reply("expected OK alone");
  return {};
}

Result<Measurement> parse_measurement(std::string_view reply) {
  DRIFTWISE_TRY(const auto words, accepted(reply));
  Measurement out;
  const char* missing = nullptr;
  const auto take = [&](const char* name, auto& value) {
    const auto text = field(words, name);
    if (!missing && (!text || !read_number(*text, value))) missing = name;
  };
  const auto take_finite = [&](const char* name, double& value) {
    take(name, value);
    if (!missing && !std::isfinite(value)) missing = name;
  };
  const auto take_time = [&](const char* name, CellTime& value) {
    const auto text = field(words, name);
    const auto time = text ? parse_unix_time(*text) : std::nullopt;
    if (!missing && !time) missing = name;
    value = time.value_or(CellTime{});
  };
  take("ch", out.channel);
  take("n", out.samples);
  take_finite("mean_nm", out.mean_nm);
  take_finite("std_nm", out.std_nm);
  take_finite("t_air_C", out.air_degc);
  take_finite("t_age_s", out.air_age_s);
  take_finite("level_pct", out.level_pct);
  const auto status = field(words, "status");
  if (!missing && (!status || !read_hex(*status, out.status))) missing = "status";
  take_time("t0", out.start);
  take_time("t1", out.end);
  if (missing) return bad_reply(std::string("field ") + missing + " is missing or no number");
  if (out.end < out.start) return bad_reply("t1 lies before t0");
  if (out.std_nm < 0) return bad_reply("std_nm is negative");
  return out;
}

Result<void> check_status(const Measurement& measurement) {
  const auto has = [&](std::uint32_t bit) { return (measurement.status & bit) != 0; };
  char text[48];
  std::snprintf(text, sizeof text, "status 0x%04x: ", static_cast<unsigned>(measurement.status));
  const std::string status = text;
  if (has(0x8000)) return fail(ErrorCode::internal, reasons::kBadRequest, status + "bad request");
  if (has(0x01))
    return fail(ErrorCode::failed_precondition, reasons::kBeamLost,
                status + "quadrant jump, the length is lost: zero again");
  if (has(0x300))
    return fail(ErrorCode::data_loss, reasons::kValuesLost, status + "values were lost (overflow)");
  if (!has(0x10))
    return fail(ErrorCode::failed_precondition, reasons::kLaserUnstable,
                status + "the laser is not stable: let it warm up");
  if (has(0x20))
    return fail(ErrorCode::failed_precondition, reasons::kLaserUnstable,
                status + "the laser was unstable since the last zero: zero again");
  if (has(0x02))
    return fail(ErrorCode::failed_precondition, reasons::kLowLevel,
                status + "the signal is too weak: clean and align the mirror");
  return {};
}

}  // namespace driftwise::adapter
