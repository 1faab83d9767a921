#include "server/formats/export/target_line.h"

#include <charconv>
#include <cmath>

#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"
#include "server/core/try.h"
#include "server/core/units.h"
#include "server/formats/text/text.h"
#include "server/formats/text/text_writer.h"

namespace driftwise::formats {
namespace {

using compensation::Snapshot;
using compensation::Target;
using compensation::TargetRequest;

tl::unexpected<Error> bad(Reason reason, const std::string& message) {
  return fail(ErrorCode::invalid_argument, reason, message);
}

bool is_blank(char c) { return c == ' ' || c == '\t'; }

std::string_view take_word(std::string_view& rest) {
  const char* start = rest.data();
  const char* const end = start + rest.size();
  while (start != end && is_blank(*start)) ++start;
  const char* after = start;
  while (after != end && !is_blank(*after)) ++after;
  rest = {after, static_cast<std::size_t>(end - after)};
  return {start, static_cast<std::size_t>(after - start)};
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
  // A plus sign as printf("%+f") writes it; from_chars knows none.
  const bool has_plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
  const auto [end, code] =
      std::from_chars(text.data() + (has_plus ? 1 : 0), text.data() + text.size(), value);
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
  const auto variable = compensation::variable_named(name);
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

// The stamp of one snapshot stands in thousands of answers: its text is kept, per thread.
const std::string& time_text(CellTime time) {
  thread_local CellTime last{-1};
  thread_local std::string text;
  if (time != last) {
    text = to_iso8601(time);
    last = time;
  }
  return text;
}

// The flags that were appended, or a dash. Then the end of the line.
template <class AppendFlags>
void append_flags_and_end(std::string& out, const AppendFlags& append_flags) {
  const std::size_t start = out.size();
  append_flags();
  out += out.size() == start ? "-\n" : "\n";
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

void write_joint_motors(TextWriter& out, const plans::JointSnapshot& snapshot,
                        const plans::JointTarget& target, bool with_uncertainty) {
  for (std::size_t r = 0; r < target.robots; ++r) {
    std::size_t at = target.robot[r].first;
    for (const std::string& motor : snapshot.robots[r].motors) {
      out << " " << motor << "_mm=" << target.q_mm[at];
      if (with_uncertainty) (out << " u90_" << motor << "_nm=").fixed(target.u90_nm(at), 2);
      ++at;
    }
  }
}

void write_joint_terms(TextWriter& out, const plans::JointSnapshot& snapshot,
                       const plans::JointTarget& target, bool with_uncertainty) {
  for (std::size_t k = 0; k < target.terms; ++k) {
    const auto& term = target.term[k];
    const auto& step = snapshot.steps[term.step];
    const std::string& name = step.terms[term.output];
    const bool angle = step.predicts.outputs[term.output].channel.unit == "arcsec";
    out << (term.added ? std::string_view(" add_") : std::string_view(" seen_")) << name
        << (angle ? std::string_view("_arcsec=") : std::string_view("_mm=")) << term.value;
    if (!with_uncertainty) continue;
    out << (term.added ? std::string_view(" u90_add_") : std::string_view(" u90_seen_")) << name;
    if (angle)
      (out << "_arcsec=").fixed(kSigmaToU90 * mm_from_nm(term.u), 4);
    else
      (out << "_nm=").fixed(kSigmaToU90 * term.u, 2);
  }
}

void write_joint_models(TextWriter& out, const plans::JointSnapshot& snapshot,
                        const plans::JointTarget& target) {
  for (std::size_t r = 0; r < target.robots; ++r) {
    const auto& robot = snapshot.robots[r];
    const auto& answer = target.robot[r];
    out << (robot.id.empty() ? std::string_view(" by") : std::string_view(" by_")) << robot.id;
    switch (answer.by) {
      case plans::AnsweredBy::one:
        out << "=one:" << robot.fine.model.value;
        break;
      case plans::AnsweredBy::fine:
        out << "=fine:" << robot.fine.model.value;
        break;
      case plans::AnsweredBy::coarse:
        out << "=coarse:" << robot.coarse->model.value;
        break;
      case plans::AnsweredBy::blend:
        (out << "=blend:" << robot.fine.model.value << "*").fixed(answer.weight, 4)
            << "+" << robot.coarse->model.value;
        break;
    }
  }
}

}  // namespace

void append_joint_answer(std::string& out, const plans::JointSnapshot& snapshot,
                         const plans::JointTarget& target, bool with_uncertainty) {
  if (target.refusal != compensation::Refusal::none)
    return append_error_answer(out, plans::joint_refusal_error(snapshot, target));
  {
    TextWriter text(out);
    text << "OK";
    write_joint_motors(text, snapshot, target, with_uncertainty);
    write_joint_terms(text, snapshot, target, with_uncertainty);
    write_joint_models(text, snapshot, target);
    text << " valid_until=" << time_text(target.valid_until) << " plan=" << snapshot.plan.value
         << " flags=";
  }
  // Several channels of a flag in one word: words are parted by blanks.
  append_flags_and_end(out, [&] { plans::append_joint_flags(out, snapshot, target, '+'); });
}

void append_target_answer(std::string& out, const Snapshot& snapshot, const Target& target,
                          bool with_uncertainty) {
  if (target.refusal != compensation::Refusal::none)
    return append_error_answer(out, compensation::refusal_error(snapshot, target));
  {
    TextWriter text(out);
    text << "OK";
    for (std::size_t i = 0; i < target.outputs; ++i) {
      const auto& channel = snapshot.outputs[i].channel;
      text << " " << channel.symbol << "_" << channel.unit << "=" << target.q_mm[i];
      if (!with_uncertainty || (target.flags & compensation::kUnjudgedModel)) continue;
      const double u90 = target.u90_nm(i);
      if (is_angle(channel.unit))
        (text << " u90_" << channel.symbol << "_arcsec=")
            .fixed(compensation::arcsec_of(channel, u90), 3);
      else if (target.outputs == 1)
        (text << " u90_nm=").fixed(u90, 2);
      else
        (text << " u90_" << channel.symbol << "_nm=").fixed(u90, 2);
    }
    text << " valid_until=" << time_text(target.valid_until) << " model=" << snapshot.model.value
         << " flags=";
  }
  append_flags_and_end(out, [&] {
    if (target.flags != 0) compensation::append_flags(out, snapshot, target, '+');
  });
}

void append_error_answer(std::string& out, const Error& error) {
  out += "ERR ";
  out += error.reason;
  out += ' ';
  out += clean_line(error.message);
  out += '\n';
}

}  // namespace driftwise::formats
