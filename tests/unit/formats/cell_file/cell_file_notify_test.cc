// [[notify]], [watchdog] and [[channel_alarm]] of a cell file.

#include <gmock/gmock.h>

#include "drivers/all_devices.h"
#include "server/formats/cell_file/cell_file.h"
#include "server/formats/cell_file/cell_file_difference.h"

namespace driftwise::formats {
namespace {

using testing::ElementsAre;

const std::string kCellWithLaser = R"([cell]
name = "small"
database = "small.db"
[[device]]
id = "laser-x"
kind = "interferometer-adapter"
address = "127.0.0.1:1"
length = "x_mm"
)";

Result<CellDescription> read_with(const std::string& more) {
  return parse_cell_file(kCellWithLaser + more, "/lab/cell.toml", drivers::all_devices());
}

TEST(CellFileNotify, IsRead) {
  const auto cell = read_with(R"([[notify]]
name = "duty"
webhook = "https://alerts.example.org/hook"
token_file = "duty.token"
levels = ["warning", "failed"]
kinds = ["run.*"]
hours = "18:00-07:30"
days = ["fri", "sat"]
repeat_h = 2
group_s = 5
resolved = false
[[notify]]
name = "mail"
smtp = "smtps://mail.example.org:465"
from = "cell@example.org"
to = ["ada@example.org", "bob@example.org"]
user = "cell"
password_file = "/etc/driftwise/mail"
[[notify]]
name = "apprise"
command = ["apprise", "-t", "{title}", "-b", "{text}"]
[watchdog]
url = "https://watch.example.org:9470/"
every_s = 15
token_file = "watch.token"
[[channel_alarm]]
channel = "x_mm"
above = 3
hysteresis = 0.5
for_s = 10
priority = "critical"
sentence = "look at the stage"
)");
  ASSERT_TRUE(cell) << cell.error().message;
  ASSERT_EQ(cell->receivers.size(), 3U);
  const auto& duty = cell->receivers[0];
  EXPECT_EQ(duty.token_file, "/lab/duty.token");
  EXPECT_EQ(duty.from_minute, 18 * 60);
  EXPECT_EQ(duty.to_minute, 7 * 60 + 30);
  EXPECT_EQ(duty.days, 0x30U);
  EXPECT_EQ(duty.repeat_h, 2);
  EXPECT_FALSE(duty.resolved);
  EXPECT_THAT(cell->receivers[1].to, ElementsAre("ada@example.org", "bob@example.org"));
  EXPECT_EQ(cell->receivers[1].password_file, "/etc/driftwise/mail");
  EXPECT_EQ(cell->receivers[2].command.size(), 5U);
  EXPECT_EQ(cell->receivers[2].repeat_h, 4);
  EXPECT_EQ(cell->watchdog.every_s, 15);
  EXPECT_EQ(cell->watchdog.token_file, "/lab/watch.token");
  ASSERT_EQ(cell->channel_alarms.size(), 1U);
  EXPECT_EQ(cell->channel_alarms[0].above, 3.0);
  EXPECT_FALSE(cell->channel_alarms[0].below);
}

struct BadNotify {
  const char* name;
  const char* text;
  const char* reason;
};
class CellFileNotifyRefuses : public testing::TestWithParam<BadNotify> {};
TEST_P(CellFileNotifyRefuses, IsRefused) {
  const auto cell = read_with(GetParam().text);
  ASSERT_FALSE(cell);
  EXPECT_EQ(cell.error().reason, GetParam().reason) << cell.error().message;
}
INSTANTIATE_TEST_SUITE_P(
    Table, CellFileNotifyRefuses,
    testing::Values(
        BadNotify{"no_way", "[[notify]]\nname = \"a\"\n", "BAD_RECEIVER"},
        BadNotify{"two_ways",
                  "[[notify]]\nname = \"a\"\nwebhook = \"http://h/\"\ncommand = [\"x\"]\n",
                  "BAD_RECEIVER"},
        BadNotify{"scheme", "[[notify]]\nname = \"a\"\nwebhook = \"ftp://h/\"\n", "BAD_RECEIVER"},
        BadNotify{"user_in_url", "[[notify]]\nname = \"a\"\nwebhook = \"https://u:p@h/\"\n",
                  "BAD_RECEIVER"},
        BadNotify{"token_in_clear",
                  "[[notify]]\nname = \"a\"\nwebhook = \"http://h/\"\ntoken_file = \"t\"\n",
                  "NEEDS_TLS"},
        BadNotify{"no_to", "[[notify]]\nname = \"a\"\nsmtp = \"smtps://h\"\nfrom = \"a@b\"\n",
                  "MISSING_KEY"},
        BadNotify{"line_feed_in_to",
                  "[[notify]]\nname = \"a\"\nsmtp = \"smtps://h\"\nfrom = \"a@b\"\nto = "
                  "[\"a@b\\r\\nBcc: c@d\"]\n",
                  "BAD_RECEIVER"},
        BadNotify{"words_in_one_text",
                  "[[notify]]\nname = \"a\"\ncommand = \"apprise -b {text}\"\n", "BAD_RECEIVER"},
        BadNotify{"hours", "[[notify]]\nname = \"a\"\ncommand = [\"x\"]\nhours = \"18-7\"\n",
                  "BAD_TIME"},
        BadNotify{"days", "[[notify]]\nname = \"a\"\ncommand = [\"x\"]\ndays = [\"friday\"]\n",
                  "BAD_TIME"},
        BadNotify{"twice",
                  "[[notify]]\nname = \"a\"\ncommand = [\"x\"]\n[[notify]]\nname = "
                  "\"a\"\ncommand = [\"x\"]\n",
                  "DUPLICATE_ID"},
        BadNotify{"kind",
                  "[[notify]]\nname = \"a\"\ncommand = [\"x\"]\nkinds = [\"device.lots\"]\n",
                  "BAD_RECEIVER"},
        BadNotify{"start_of_no_kind",
                  "[[notify]]\nname = \"a\"\ncommand = [\"x\"]\nkinds = [\"runs.*\"]\n",
                  "BAD_RECEIVER"},
        BadNotify{"unknown_key", "[[notify]]\nname = \"a\"\ncommand = [\"x\"]\nhour = 3\n",
                  "UNKNOWN_KEY"},
        BadNotify{"watchdog_token_in_clear",
                  "[watchdog]\nurl = \"http://10.0.0.2:9470/\"\ntoken_file = \"t\"\n", "NEEDS_TLS"},
        BadNotify{"both_limits", "[[channel_alarm]]\nchannel = \"x_mm\"\nabove = 1\nbelow = 0\n",
                  "BAD_LIMITS"},
        BadNotify{"no_such_channel", "[[channel_alarm]]\nchannel = \"t99_degC\"\nabove = 1\n",
                  "NO_SUCH_CHANNEL"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(CellFileNotify, NamesTheKindThatWasMeant) {
  const auto sentence_of = [](const std::string& kind) {
    const auto cell =
        read_with("[[notify]]\nname = \"a\"\ncommand = [\"x\"]\nkinds = [\"" + kind + "\"]\n");
    return cell ? std::string() : cell.error().message;
  };
  EXPECT_THAT(sentence_of("device.lots"), testing::HasSubstr("did you mean 'device.lost'?"));
  EXPECT_THAT(sentence_of("runs.*"), testing::HasSubstr("did you mean 'run.*'?"));
  EXPECT_THAT(sentence_of("door_was_opened"), testing::HasSubstr("docs/alarms.md"));
  for (const char* good : {"device.lost", "run.*", "queue.f*", "*"})
    EXPECT_EQ(sentence_of(good), "");
}

// Whom a cell tells is no reason to ask before a run goes on.
TEST(CellFileNotify, AChangeIsRecordedOnly) {
  const auto after = read_with(
      "[[notify]]\nname = \"a\"\ncommand = [\"x\"]\n[watchdog]\nurl = \"https://h/\"\n"
      "[[channel_alarm]]\nchannel = \"x_mm\"\nabove = 1\n");
  ASSERT_TRUE(after) << after.error().message;
  const auto changes = cell_file_difference(kCellWithLaser, *after);
  EXPECT_FALSE(changes.empty());
  EXPECT_FALSE(any_asks(changes));
}

}  // namespace
}  // namespace driftwise::formats
