#include "server/formats/export/target_line.h"

#include <charconv>
#include <cmath>

#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"
#include "server/core/try.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

using compensation::Snapshot;
using compensation::Target;
using compensation::TargetRequest;

tl::unexpected<Error> bad(Reason reason, const std::string& message) {
  return fail(ErrorCode::invalid_argument, reason, message);
}

std::string_view take_word(std::string_view& rest) {
  const auto start = rest.find_first_not_of(" \t");
  if (start == std::string_view::npos) {
    rest = {};
    return {};
  }
  rest.remove_prefix(start);
  const auto word = rest.substr(0, rest.find_first_of(" \t"));
  rest.remove_prefix(word.size());
  return word;
}

std::optional<compensation::Variable> variable_named(std::string_view name) {
  const auto cut = name.rfind('_');
  if (cut == std::string_view::npos) return std::nullopt;
  const auto variable = compensation::variable_from(name.substr(0, cut));
  if (!variable || compensation::channel_of(*variable).unit != name.substr(cut + 1))
    return std::nullopt;
  return variable;
}

Result<void> read_word(std::string_view word, TargetRequest& request, bool& asked_u) {
  const auto equals = word.find('=');
  if (equals == std::string_view::npos)
    return bad(reasons::kBadWord,
               "found " + shown(word) + ", expected name=value such as x_mm=1.5");
  const auto name = word.substr(0, equals), text = word.substr(equals + 1);
  if (name == "u") {
    if (asked_u) return bad(reasons::kDuplicateName, "found u twice, expected it once");
    if (text != "0" && text != "1")
      return bad(reasons::kBadFlag, "u: found " + shown(text) + ", expected 0 or 1");
    asked_u = true;
    request.with_uncertainty = text == "1";
    return {};
  }
  const auto variable = variable_named(name);
  if (!variable)
    return bad(reasons::kUnknownName,
               "found " + shown(name) +
                   ", expected x_mm, y_mm, z_mm, rx_arcsec, ry_arcsec, rz_arcsec, force_N or u");
  if (request.given & compensation::bit(*variable))
    return bad(reasons::kDuplicateName, "found " + shown(name) + " twice, expected it once");
  double value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    return bad(reasons::kBadNumber, std::string(name) + ": found " + shown(text) +
                                        ", expected a finite number such as 1.5");
  request.set(*variable, value);
  return {};
}

void append_fixed(std::string& out, double value, int decimals) {
  char digits[64];
  const auto [end, code] =
      std::to_chars(digits, digits + sizeof digits, value, std::chars_format::fixed, decimals);
  if (code == std::errc{})
    out.append(digits, end);
  else
    append_number(out, value);
}

// The stamp of one snapshot stands in thousands of answers: its text is kept, per thread.
void append_time(std::string& out, CellTime time) {
  thread_local CellTime last{-1};
  thread_local std::string text;
  if (time != last) {
    text = to_iso8601(time);
    last = time;
  }
  out += text;
}

}  // namespace

Result<TargetRequest> parse_target_line(std::string_view line) {
  if (line.size() > kMaxTargetLine)
    return bad(reasons::kLineTooLong, "found " + std::to_string(line.size()) +
                                          " bytes, expected at most " +
                                          std::to_string(kMaxTargetLine));
  std::string_view rest = line;
  const auto verb = take_word(rest);
  if (verb != "TARGET")
    return bad(reasons::kUnknownVerb, "found " +
                                          (verb.empty() ? std::string("nothing") : shown(verb)) +
                                          ", expected TARGET x_mm=1.5 u=1");
  TargetRequest request;
  request.with_uncertainty = false;
  bool asked_u = false;
  for (auto word = take_word(rest); !word.empty(); word = take_word(rest))
    DRIFTWISE_RETURN_IF_ERROR(read_word(word, request, asked_u));
  return request;
}

void append_target_answer(std::string& out, const Snapshot& snapshot, const Target& target,
                          bool with_uncertainty) {
  if (target.refusal != compensation::Refusal::none)
    return append_error_answer(out, compensation::refusal_error(snapshot, target));
  out += "OK";
  for (std::size_t i = 0; i < target.outputs; ++i) {
    out += ' ';
    out += snapshot.outputs[i].channel.symbol;
    out += "_mm=";
    append_number(out, target.q_mm[i]);
    if (!with_uncertainty) continue;
    out += target.outputs == 1 ? " u90_nm=" : " u90_" + snapshot.outputs[i].channel.symbol + "_nm=";
    append_fixed(out, target.u90_nm(i), 2);
  }
  out += " valid_until=";
  append_time(out, target.valid_until);
  out += " model=";
  append_number(out, snapshot.model.value);
  out += " flags=";
  if (target.flags == 0) {
    out += '-';
  } else {
    std::string flags = compensation::describe_flags(snapshot, target);
    for (char& c : flags)
      if (c == ' ') c = '+';  // several channels in one word: words are parted by blanks
    out += flags;
  }
  out += '\n';
}

void append_error_answer(std::string& out, const Error& error) {
  out += "ERR ";
  out += error.reason;
  out += ' ';
  out += clean_line(error.message);
  out += '\n';
}

}  // namespace driftwise::formats
