#include "tests/faults/lies/lie_table.h"

#include <fmt/format.h>

#include <cmath>
#include <iostream>
#include <map>

namespace driftwise::lies {
namespace {

constexpr double kImpossibleWithin_s = 10;

std::string problem_of(const Episode& episode, Kind kind) {
  if (!episode.detected) return "not found";
  if (!episode.alarmed) return "no alarm";
  if (is_impossible(kind) && episode.after_s > kImpossibleWithin_s)
    return fmt::format("found after {:.0f} s only", episode.after_s);
  if (episode.after_closure) return "found after the next closure only";
  if (episode.unmarked_rows > 0)
    return fmt::format("{} false rows are not marked", episode.unmarked_rows);
  if (episode.alarm_stays) return "the alarm stays when the lie has ended";
  if (!episode.went_on) return "the run did not go on when the lie ended";
  return "";
}

std::string cell_text(const Entry& entry, std::map<std::string, std::size_t>& reasons) {
  if (!entry.not_detectable.empty()) {
    const auto [found, is_new] = reasons.try_emplace(entry.not_detectable, reasons.size() + 1);
    return fmt::format("- ({})", found->second);
  }
  const auto& at = entry.size ? entry.at_smallest : entry.at_twice;
  std::string how = at.how;
  for (const char* front : {"reading.", "pose.", "closure."})
    if (how.starts_with(front)) how = how.substr(std::string(front).size());
  auto text = entry.size ? fmt::format("{:.2g}, {:.0f} s, {}", *entry.size, at.after_s, how)
                         : fmt::format("{:.0f} s, {}", at.after_s, how);
  if (!entry.problem.empty()) text += " **" + entry.problem + "**";
  return text;
}

}  // namespace

Entry measure(LieBench& bench, const ChannelOfCell& channel, Kind kind, Effort effort) {
  Entry entry;
  entry.not_detectable = bench.why_not(channel, kind);
  if (!entry.not_detectable.empty()) return entry;
  if (!has_size(kind)) {
    entry.at_twice = bench.tell(channel, kind, 0);
    entry.problem = problem_of(entry.at_twice, kind);
    return entry;
  }
  const auto expected =
      expected_size(bench.description(), channel, kind, bench.truth(channel.name));
  if (!expected) {
    entry.not_detectable = "the value is 0: a share of it is 0 too";
    return entry;
  }
  entry.size = *expected;
  // A readback that is late is harmless until a move takes too long: nothing smaller is found.
  if (effort == Effort::whole && kind != Kind::late)
    for (const double share : {0.25, 0.5, 1.0, 2.0, 4.0, 8.0})
      if (const auto episode = bench.tell(channel, kind, share * *expected); episode.detected) {
        entry.size = share * *expected;
        entry.at_smallest = episode;
        break;
      }
  entry.at_twice = bench.tell(channel, kind, 2 * *entry.size);
  if (!entry.at_smallest.detected) entry.at_smallest = entry.at_twice;
  entry.problem = problem_of(entry.at_twice, kind);
  return entry;
}

int print_table(const std::string& cell, Effort effort, std::ostream& out) {
  LieBench bench(cell);
  std::map<std::string, std::size_t> reasons;
  std::vector<std::string> problems;
  out << "## " << cell << "\n\n| channel |";
  for (const Kind kind : kKinds) out << ' ' << name_of(kind) << " |";
  out << "\n|---|";
  for (std::size_t i = 0; i < kKinds.size(); ++i) out << "---|";
  out << '\n';
  for (const auto& channel : bench.channels()) {
    out << "| " << channel.name << " |";
    for (const Kind kind : kKinds) {
      const auto entry = measure(bench, channel, kind, effort);
      out << ' ' << cell_text(entry, reasons) << " |" << std::flush;
      if (!entry.problem.empty())
        problems.push_back(channel.name + ", " + name_of(kind) + ": " + entry.problem + " (" +
                           entry.at_twice.said + ")");
    }
    out << '\n';
  }
  out << '\n';
  for (std::size_t number = 1; number <= reasons.size(); ++number)
    for (const auto& [reason, is] : reasons)
      if (is == number) out << '(' << number << ") Not detectable: " << reason << ".\n";
  const auto alarms = bench.tell_the_truth(effort == Effort::whole ? 100 : 20);
  out << "\nTrue devices, " << (effort == Effort::whole ? 100 : 20) << " lines: " << alarms.size()
      << " alarms.\n";
  for (const auto& alarm : alarms) problems.push_back("true devices: " + alarm);
  for (const auto& problem : problems) out << "\nPROBLEM " << problem;
  out << '\n';
  return static_cast<int>(problems.size());
}

}  // namespace driftwise::lies
