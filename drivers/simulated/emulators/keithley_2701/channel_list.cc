#include "drivers/simulated/emulators/keithley_2701/channel_list.h"

#include "drivers/simulated/emulators/switches.h"
#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {
namespace {

constexpr std::size_t kListLimit = 1000;

int channels_of(const std::string& card) {
  if (card == "7700") return 20;
  if (card == "7708") return 40;
  if (card == "NONE") return 0;
  throw SetupError("[emulator.scanner] slot: found card '" + card +
                   "', expected 7700, 7708 or NONE");
}

}  // namespace

Cards::Cards(const std::string& slot1, const std::string& slot2)
    : names_{slot1, slot2}, counts_{channels_of(slot1), channels_of(slot2)} {}

bool Cards::exists(int channel) const {
  const int slot = channel / 100;
  return (slot == 1 || slot == 2) && channel % 100 >= 1 && channel % 100 <= counts_[slot - 1];
}

std::optional<int> Cards::partner(int channel) const {
  const int half = exists(channel) ? counts_[channel / 100 - 1] / 2 : 0;
  if (channel % 100 > half) return std::nullopt;
  return channel + half;
}

std::vector<int> Cards::all() const {
  std::vector<int> out;
  for (int slot = 1; slot <= 2; ++slot)
    for (int i = 1; i <= counts_[slot - 1]; ++i) out.push_back(100 * slot + i);
  return out;
}

ChannelListParse parse_channel_list(std::string_view text, const Cards& cards) {
  text = trim(text);
  if (!text.starts_with("(@") || !text.ends_with(")")) return {{}, -102};
  ChannelListParse out;
  for (const auto& piece : split_arguments(text.substr(2, text.size() - 3))) {
    const std::size_t colon = piece.find(':');
    const auto from = parse_integer(trim(std::string_view(piece).substr(0, colon)));
    const auto to = colon == std::string::npos
                        ? from
                        : parse_integer(trim(std::string_view(piece).substr(colon + 1)));
    if (!from || !to) return {{}, -102};
    if (!cards.exists(*from) || !cards.exists(*to)) return {{}, -222};
    const int step = *to >= *from ? 1 : -1;
    for (int channel = *from; channel != *to + step; channel += step) {
      if (!cards.exists(channel)) continue;  // 118:203 runs over the end of slot 1
      if (out.channels.size() >= kListLimit) return {{}, -222};
      out.channels.push_back(channel);
    }
  }
  return out;
}

std::string channel_list_text(const std::vector<int>& channels) {
  std::string out = "(@";
  for (std::size_t i = 0; i < channels.size();) {
    std::size_t end = i;
    while (end + 1 < channels.size() && channels[end + 1] == channels[end] + 1) ++end;
    out += (i == 0 ? "" : ",") + std::to_string(channels[i]);
    if (end > i) out += (end == i + 1 ? "," : ":") + std::to_string(channels[end]);
    i = end + 1;
  }
  return out + ")";
}

}  // namespace driftwise::simulated
