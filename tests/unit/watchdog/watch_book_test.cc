// Cells that fall silent, and records that become other ones.

#include "server/watchdog/watch_book.h"

#include <gmock/gmock.h>

namespace driftwise::watchdog {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

UtcTime at(double s) { return {1'795'248'000'000'000'000 + static_cast<std::int64_t>(s * 1e9)}; }
LifeSign sign_of(const std::string& cell, std::int64_t entry = 0, char digit = 'a') {
  LifeSign sign;
  sign.cell = cell;
  if (entry > 0) sign.head = {entry, std::string(64, digit)};
  return sign;
}

TEST(WatchBook, ACellThatSpeaksIsNoAlarm) {
  WatchBook book(120);
  for (double s = 0; s < 1000; s += 30) {
    EXPECT_THAT(book.take(sign_of("a"), {}, s, at(s)), IsEmpty());
    EXPECT_THAT(book.look(s + 29, at(s + 29)), IsEmpty());
  }
}

TEST(WatchBook, SilenceIsOneAlarmAndItsEndIsTold) {
  WatchBook book(120);
  ASSERT_THAT(book.take(sign_of("a"), {}, 0, at(0)), IsEmpty());
  ASSERT_THAT(book.look(119, at(119)), IsEmpty());
  const auto silent = book.look(120, at(120));
  ASSERT_EQ(silent.size(), 1U);
  EXPECT_EQ(silent[0].kind, NewsKind::firing);
  EXPECT_EQ(silent[0].alarm.kind, "cell.silent");
  EXPECT_THAT(silent[0].alarm.message, HasSubstr("a has fallen silent: its last sign of life came "
                                                 "at 2026-11-21T08:00:00Z"));
  EXPECT_THAT(book.look(500, at(500)), IsEmpty());
  const auto back = book.take(sign_of("a"), {}, 600, at(600));
  ASSERT_EQ(back.size(), 1U);
  EXPECT_EQ(back[0].kind, NewsKind::resolved);
  EXPECT_EQ(back[0].alarm.id, silent[0].alarm.id);
  EXPECT_EQ(back[0].cleared, at(600));
  EXPECT_EQ(book.look(720, at(720)).size(), 1U);  // it falls silent again: another alarm
}

TEST(WatchBook, AnExpectedCellThatNeverSpeaksIsAnAlarm) {
  WatchBook book(120);
  book.expect("b", 0, at(0));
  const auto silent = book.look(130, at(130));
  ASSERT_EQ(silent.size(), 1U);
  EXPECT_THAT(silent[0].alarm.message, HasSubstr("no sign of life since this watchdog started"));
}

TEST(WatchBook, AChainThatGoesBackOrChangesIsAnAlarm) {
  WatchBook book(120);
  const ChainHead known{17, std::string(64, 'a')};
  EXPECT_THAT(book.take(sign_of("a", 17), known, 0, at(0)), IsEmpty());
  EXPECT_THAT(book.take(sign_of("a", 18, 'b'), known, 0, at(0)), IsEmpty());
  EXPECT_EQ(book.take(sign_of("a", 17, 'b'), known, 0, at(0)).size(), 1U);
  const auto back = book.take(sign_of("a", 3), known, 0, at(0));
  ASSERT_EQ(back.size(), 1U);
  EXPECT_EQ(back[0].alarm.kind, "chain.changed");
  EXPECT_THAT(back[0].alarm.message, HasSubstr("audit verify --head " + to_string(known)));
}

}  // namespace
}  // namespace driftwise::watchdog
