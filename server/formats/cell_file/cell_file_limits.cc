#include "server/formats/cell_file/cell_file_limits.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/formats/cell_file/cell_file_holds.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

void optional_number(TomlReader& reader, const char* key, std::optional<double>& value,
                     Range range = {}) {
  if (!reader.has(key)) {
    double ignored = 0;
    reader.number(key, ignored, range);  // so that the key is known
    return;
  }
  double number = 0;
  reader.number(key, number, range);
  value = number;
}

}  // namespace

void read_plausibility(TomlReader&& reader, PlausibilityRules& out) {
  constexpr Range kPositive{.min = 0, .max = 1e9, .above_min = true};
  reader.number("geometry_um", out.geometry_um, kPositive);
  reader.number("geometry_pct", out.geometry_pct, {.min = 0, .max = 100});
  reader.number("closure_nm", out.closure_nm, kPositive);
  optional_number(reader, "closure_nm_per_min", out.closure_nm_per_min, {.min = 0, .max = 1e9});
  reader.number("closure_arcsec", out.closure_arcsec, kPositive);
  reader.number("together_k", out.together_k, kPositive);
  reader.finish();
}

void read_limit(TomlReader&& reader, const std::vector<std::string>& channels,
                PlausibilityRules& out) {
  ChannelLimitDescription limit;
  Channel channel;
  reader.robot_channel("channel", channel, Need::required);
  limit.channel = channel.symbol.empty() ? "" : channel.name();
  check_is_read(reader, "channel", limit.channel, channels);
  optional_number(reader, "min", limit.min);
  optional_number(reader, "max", limit.max);
  optional_number(reader, "max_step", limit.max_step, {.min = 0, .max = 1e300, .above_min = true});
  optional_number(reader, "max_per_s", limit.max_per_s, {.min = 0, .max = 1e300});
  int frozen = 0;
  reader.integer("frozen_answers", frozen, 0, 1'000'000);
  if (reader.has("frozen_answers")) limit.frozen_answers = frozen;
  if (limit.min && limit.max && !(*limit.min < *limit.max))
    reader.refuse("min", reasons::kBadLimits,
                  "found min = " + number_text(*limit.min) +
                      " and max = " + number_text(*limit.max) + ", expected min below max");
  if (std::ranges::find(out.limits, limit.channel, &ChannelLimitDescription::channel) !=
      out.limits.end())
    reader.refuse("channel", reasons::kDuplicateChannel,
                  "found " + shown(limit.channel) + ", which another [[limit]] has already");
  reader.finish();
  out.limits.push_back(std::move(limit));
}

}  // namespace driftwise::formats
