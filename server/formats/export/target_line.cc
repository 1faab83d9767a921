#include "server/formats/export/target_line.h"

#include <charconv>
#include <cmath>

#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"
#include "server/core/try.h"
#include "server/core/units.h"
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

// Calls take(name, value) for name=value, or reads u.
template <class Take>
Result<void> read_word(std::string_view word, bool& with_uncertainty, bool& asked_u,
                       const Take& take) {
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
    with_uncertainty = text == "1";
    return {};
  }
  double value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    return bad(reasons::kBadNumber, std::string(name) + ": found " + shown(text) +
                                        ", expected a finite number such as 1.5");
  return take(name, value);
}

Result<void> set_coordinate(TargetRequest& request, std::string_view name, double value) {
  constexpr std::string_view kNear = "near_";  // near_q2_rad: of an arm
  if (name.starts_with(kNear)) {
    const auto taken = compensation::set_near(request, name.substr(kNear.size()), value);
    if (taken == compensation::NearName::twice)
      return bad(reasons::kDuplicateName, "found " + shown(name) + " twice, expected it once");
    if (taken == compensation::NearName::taken) return {};
  }
  const auto variable = variable_named(name);
  if (!variable)
    return bad(reasons::kUnknownName,
               "found " + shown(name) +
                   ", expected x_mm, y_mm, z_mm, rx_arcsec, ry_arcsec, rz_arcsec, force_N or u; "
                   "of an arm also near_q1_rad or near_q1_deg");
  if (request.given & compensation::bit(*variable))
    return bad(reasons::kDuplicateName, "found " + shown(name) + " twice, expected it once");
  request.set(*variable, value);
  return {};
}

Result<void> check_length(std::string_view line) {
  if (line.size() <= kMaxTargetLine) return {};
  return bad(reasons::kLineTooLong, "found " + std::to_string(line.size()) +
                                        " bytes, expected at most " +
                                        std::to_string(kMaxTargetLine));
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
  DRIFTWISE_RETURN_IF_ERROR(check_length(line));
  std::string_view rest = line;
  const auto verb = take_word(rest);
  if (verb != "TARGET")
    return bad(reasons::kUnknownVerb, "found " +
                                          (verb.empty() ? std::string("nothing") : shown(verb)) +
                                          ", expected TARGET x_mm=1.5 u=1, or JOINT ma.z_mm=3 ...");
  TargetRequest request;
  request.with_uncertainty = false;
  bool asked_u = false;
  for (auto word = take_word(rest); !word.empty(); word = take_word(rest))
    DRIFTWISE_RETURN_IF_ERROR(read_word(
        word, request.with_uncertainty, asked_u,
        [&](std::string_view name, double value) { return set_coordinate(request, name, value); }));
  return request;
}

Result<plans::JointRequest> parse_joint_line(std::string_view line,
                                             const plans::JointSnapshot& snapshot) {
  DRIFTWISE_RETURN_IF_ERROR(check_length(line));
  std::string_view rest = line;
  if (const auto verb = take_word(rest); verb != "JOINT")
    return bad(reasons::kUnknownVerb, "found " + shown(verb) + ", expected JOINT ma.z_mm=3 ...");
  plans::JointRequest request;
  request.with_uncertainty = false;
  bool asked_u = false;
  const auto set = [&](std::string_view name, double value) -> Result<void> {
    if (snapshot.robots.empty()) return {};  // no plan serves, which is the answer
    DRIFTWISE_TRY(const auto place, plans::joint_name(snapshot, name));
    if (request.given[place.robot] & compensation::bit(place.variable))
      return bad(reasons::kDuplicateName, "found " + shown(name) + " twice, expected it once");
    request.set(place.robot, place.variable, value);
    return {};
  };
  for (auto word = take_word(rest); !word.empty(); word = take_word(rest))
    DRIFTWISE_RETURN_IF_ERROR(read_word(word, request.with_uncertainty, asked_u, set));
  return request;
}

namespace {

void append_joint_name(std::string& out, const std::string& robot, std::string_view symbol) {
  if (!robot.empty()) (out += robot) += '.';
  out += symbol;
}

void append_joint_motors(std::string& out, const plans::JointSnapshot& snapshot,
                         const plans::JointTarget& target, bool with_uncertainty) {
  for (std::size_t r = 0; r < target.robots; ++r) {
    const auto& robot = snapshot.robots[r];
    for (std::size_t i = 0; i < target.robot[r].outputs; ++i) {
      const std::size_t at = target.robot[r].first + i;
      out += ' ';
      append_joint_name(out, robot.id, robot.fine.outputs[i].channel.symbol);
      out += "_mm=";
      append_number(out, target.q_mm[at]);
      if (!with_uncertainty) continue;
      out += " u90_";
      append_joint_name(out, robot.id, robot.fine.outputs[i].channel.symbol);
      out += "_nm=";
      append_fixed(out, target.u90_nm(at), 2);
    }
  }
}

void append_joint_terms(std::string& out, const plans::JointSnapshot& snapshot,
                        const plans::JointTarget& target, bool with_uncertainty) {
  for (std::size_t k = 0; k < target.terms; ++k) {
    const auto& term = target.term[k];
    const auto& step = snapshot.steps[term.step];
    const auto& channel = step.predicts.outputs[term.output].channel;
    const std::string& robot = snapshot.robots[term.added ? step.to : step.from].id;
    const bool angle = channel.unit == "arcsec";
    const auto name = [&](std::string_view before) {
      out += before;
      out += term.added ? "add_" : "seen_";
      append_joint_name(out, robot, channel.symbol);
    };
    name(" ");
    (out += '_') += channel.unit;
    out += '=';
    append_number(out, term.value);
    if (!with_uncertainty) continue;
    name(" u90_");
    out += angle ? "_arcsec=" : "_nm=";
    append_fixed(out, kSigmaToU90 * (angle ? mm_from_nm(term.u) : term.u), angle ? 4 : 2);
  }
}

void append_joint_models(std::string& out, const plans::JointSnapshot& snapshot,
                         const plans::JointTarget& target) {
  for (std::size_t r = 0; r < target.robots; ++r) {
    const auto& robot = snapshot.robots[r];
    const auto& answer = target.robot[r];
    out += robot.id.empty() ? " by" : " by_";
    out += robot.id;
    out += '=';
    switch (answer.by) {
      case plans::AnsweredBy::one:
        out += "one:";
        break;
      case plans::AnsweredBy::fine:
        out += "fine:";
        break;
      case plans::AnsweredBy::coarse:
        out += "coarse:";
        break;
      case plans::AnsweredBy::blend:
        out += "blend:";
        break;
    }
    if (answer.by != plans::AnsweredBy::coarse) append_number(out, robot.fine.model.value);
    if (answer.by == plans::AnsweredBy::blend) {
      out += '*';
      append_fixed(out, answer.weight, 4);
      out += '+';
    }
    if (answer.by == plans::AnsweredBy::coarse || answer.by == plans::AnsweredBy::blend)
      append_number(out, robot.coarse->model.value);
  }
}

}  // namespace

void append_joint_answer(std::string& out, const plans::JointSnapshot& snapshot,
                         const plans::JointTarget& target, bool with_uncertainty) {
  if (target.refusal != compensation::Refusal::none)
    return append_error_answer(out, plans::joint_refusal_error(snapshot, target));
  out += "OK";
  append_joint_motors(out, snapshot, target, with_uncertainty);
  append_joint_terms(out, snapshot, target, with_uncertainty);
  append_joint_models(out, snapshot, target);
  out += " valid_until=";
  append_time(out, target.valid_until);
  out += " plan=";
  append_number(out, snapshot.plan.value);
  out += " flags=";
  const auto flags = plans::describe_joint_flags(snapshot, target);
  if (flags.empty()) out += '-';
  for (std::size_t i = 0; i < flags.size(); ++i) {
    if (i > 0) out += ',';
    for (const char c : flags[i]) out += c == ' ' ? '+' : c;
  }
  out += '\n';
}

void append_target_answer(std::string& out, const Snapshot& snapshot, const Target& target,
                          bool with_uncertainty) {
  if (target.refusal != compensation::Refusal::none)
    return append_error_answer(out, compensation::refusal_error(snapshot, target));
  out += "OK";
  for (std::size_t i = 0; i < target.outputs; ++i) {
    out += ' ';
    const auto& channel = snapshot.outputs[i].channel;
    out += channel.symbol;
    out += '_';
    out += channel.unit;
    out += '=';
    append_number(out, target.q_mm[i]);
    if (!with_uncertainty || (target.flags & compensation::kUnjudgedModel)) continue;
    if (is_angle(channel.unit)) {
      out += " u90_" + channel.symbol + "_arcsec=";
      append_fixed(out, compensation::arcsec_of(channel, target.u90_nm(i)), 3);
      continue;
    }
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
