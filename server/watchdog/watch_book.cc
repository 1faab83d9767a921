#include "server/watchdog/watch_book.h"

#include <fmt/format.h>

namespace driftwise::watchdog {

void WatchBook::expect(const std::string& cell, double now_s, UtcTime now) {
  cells_.try_emplace(cell, Cell{now_s, now, false, {}});
}

AlarmNews WatchBook::raise(const std::string& cell, const char* kind, std::string message,
                           UtcTime now) {
  AlarmNews news;
  news.alarm.id = {++last_id_};
  news.alarm.level = AlarmLevel::failed;
  news.alarm.kind = kind;
  news.alarm.subject = cell;
  news.alarm.message = std::move(message);
  news.alarm.since = {now.ns};
  news.since = now;
  return news;
}

std::vector<AlarmNews> WatchBook::take(const LifeSign& sign, const ChainHead& known, double now_s,
                                       UtcTime now) {
  std::vector<AlarmNews> news;
  Cell& cell = cells_[sign.cell];
  cell.heard_s = now_s;
  cell.heard = now;
  cell.ever = true;
  if (cell.silence.id.value != 0) {
    cell.silence.cleared = {now.ns};
    news.push_back({cell.silence, NewsKind::resolved, {cell.silence.since.utc_ns}, now});
    cell.silence = {};
  }
  const bool backwards = sign.head.entry < known.entry;
  const bool other = sign.head.entry == known.entry && sign.head.hash != known.hash;
  if (known.entry != 0 && sign.head.entry != 0 && (backwards || other))
    news.push_back(raise(
        sign.cell, "chain.changed",
        fmt::format("the record of {} has become another one: its chain was told as {} and is now "
                    "{}. Check it: driftwise audit verify --head {}",
                    sign.cell, to_string(known), to_string(sign.head), to_string(known)),
        now));
  return news;
}

std::vector<AlarmNews> WatchBook::look(double now_s, UtcTime now) {
  std::vector<AlarmNews> news;
  for (auto& [name, cell] : cells_) {
    if (cell.silence.id.value != 0 || now_s - cell.heard_s < silent_after_s_) continue;
    news.push_back(raise(
        name, "cell.silent",
        cell.ever ? fmt::format("{} has fallen silent: its last sign of life came at {}, {:.0f} s "
                                "ago. Look for its computer, its daemon and the network between",
                                name, to_iso8601(cell.heard), now_s - cell.heard_s)
                  : fmt::format("{} has given no sign of life since this watchdog started at {}",
                                name, to_iso8601(cell.heard)),
        now));
    cell.silence = news.back().alarm;
  }
  return news;
}

}  // namespace driftwise::watchdog
