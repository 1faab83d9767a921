#include "clients/cpp/convert.h"

namespace driftwise::client {
namespace {

std::chrono::system_clock::time_point instant_of(const google::protobuf::Timestamp& time) {
  const auto since_epoch =
      std::chrono::seconds(time.seconds()) + std::chrono::nanoseconds(time.nanos());
  return std::chrono::system_clock::time_point(
      std::chrono::duration_cast<std::chrono::system_clock::duration>(since_epoch));
}

template <class Names>
std::string with_names(std::string flag, const Names& names) {
  std::string joined;
  for (const auto& name : names) joined += (joined.empty() ? "" : "+") + name;
  return joined.empty() ? flag : flag + "(" + joined + ")";
}

// "q3_mm" -> "q3", as the text line has it.
template <class Names>
std::vector<std::string> without_unit(const Names& names) {
  std::vector<std::string> out;
  for (const auto& name : names) out.push_back(name.substr(0, name.rfind('_')));
  return out;
}

std::string flag_text(v1::Target::Flag flag, const v1::Target& target) {
  switch (flag) {
    case v1::Target::FLAG_OUTSIDE_DOMAIN:
      return with_names("OUTSIDE_DOMAIN", target.outside_channels());
    case v1::Target::FLAG_STALE_TEMPERATURE:
      return with_names("STALE_TEMPERATURE", target.stale_channels());
    case v1::Target::FLAG_MISSING_TEMPERATURE:
      return with_names("MISSING_TEMPERATURE", target.missing_channels());
    case v1::Target::FLAG_OUTSIDE_LIMITS:
      return with_names("OUTSIDE_LIMITS", without_unit(target.unreachable_channels()));
    case v1::Target::FLAG_UNKNOWN_LIMITS:
      return with_names("UNKNOWN_LIMITS", without_unit(target.unlimited_channels()));
    case v1::Target::FLAG_IGNORED_COORDINATE:
      return with_names("IGNORED_COORDINATE", target.ignored_channels());
    case v1::Target::FLAG_ZERO_OUTSIDE_DOMAIN:
      return with_names("ZERO_OUTSIDE_DOMAIN", target.zero_outside_channels());
    default: {
      constexpr std::string_view kPrefix = "FLAG_";
      const std::string name = v1::Target::Flag_Name(flag);
      return name.empty() ? "UNKNOWN_FLAG(" + std::to_string(flag) + ")"
                          : name.substr(kPrefix.size());
    }
  }
}

}  // namespace

Target target_from(const v1::Target& message) {
  Target target;
  for (const auto& one : message.coordinates())
    target.coordinates.push_back(
        {one.channel(), one.position_mm(), one.u90_nm(), one.expanded_nm()});
  target.model_id = message.model_id();
  target.conditions_time = instant_of(message.conditions_time());
  target.valid_until = instant_of(message.valid_until_time());
  for (const int flag : message.flags())
    target.flags.push_back(flag_text(static_cast<v1::Target::Flag>(flag), message));
  return target;
}

}  // namespace driftwise::client
