#pragma once
// Scanner channels "(@101:110,203)" and which of them exist: slot * 100 + channel of the card in
// the slot. On a four-wire function channel n of a card is measured together with its partner n +
// half, which then is no channel of its own.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace driftwise::simulated {

class Cards {
 public:
  // "7700" (20 channels), "7708" (40) or "NONE" for slots 1, 2. Throws SetupError.
  Cards(const std::string& slot1, const std::string& slot2);

  bool exists(int channel) const;
  // The partner that a four-wire function takes; nullopt when the channel itself is in the upper
  // half.
  std::optional<int> partner(int channel) const;
  std::vector<int> all() const;
  std::string options() const { return names_[0] + "," + names_[1]; }  // *OPT?

 private:
  std::string names_[2];
  int counts_[2];
};

// "(@101:110,203)"; a range may run down. Errors: -102 not a list, -222 a channel that is not there
// or more than 1000 entries.
struct ChannelListParse {
  std::vector<int> channels;
  int error = 0;
};
ChannelListParse parse_channel_list(std::string_view text, const Cards& cards);
std::string channel_list_text(const std::vector<int>& channels);  // ascending runs as ranges

}  // namespace driftwise::simulated
