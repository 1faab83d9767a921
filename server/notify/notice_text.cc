#include "server/notify/notice_text.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "server/core/text/clean_text.h"
#include "server/core/text/with_subject.h"

namespace driftwise::notify {
namespace {

constexpr const char* kTest = "a test: nothing is wrong";

std::string word_of(const AlarmNews& news) {
  if (news.kind == NewsKind::resolved) return "over";
  return (news.kind == NewsKind::repeat ? "still " : "") +
         std::string(to_string(news.alarm.priority()));
}

}  // namespace

std::string_view severity_of(const AlarmRecord& alarm) {
  switch (alarm.priority()) {
    case AlarmPriority::low:
      return "info";
    case AlarmPriority::medium:
      return "warning";
    case AlarmPriority::high:
    case AlarmPriority::critical:
      return "critical";
  }
  return "warning";
}

bool is_on_record(const Notice& notice, const AlarmRecord& alarm) {
  return notice.is_of_record && alarm.id.value > 0;
}

bool is_resolved(const Notice& notice) {
  return !notice.news.empty() && std::ranges::all_of(notice.news, [](const AlarmNews& news) {
    return news.kind == NewsKind::resolved;
  });
}

// FNV-1a, 64 bits.
std::string fingerprint_of(const std::string& cell, const AlarmRecord& alarm) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const std::string* text : {&cell, &alarm.kind, &alarm.subject}) {
    for (const char c : *text + '\n') {
      hash ^= static_cast<unsigned char>(c);
      hash *= 1099511628211ULL;
    }
  }
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (int shift = 60; shift >= 0; shift -= 4) text += kDigits[(hash >> shift) & 0xF];
  return text;
}

std::string title_of(const Notice& notice) {
  std::string title = "[" + notice.cell + "] ";
  if (notice.news.empty()) return clean_line(title + kTest);
  // The gravest first.
  const auto& first = *std::ranges::max_element(notice.news, {}, [](const AlarmNews& news) {
    return news.kind == NewsKind::resolved ? -1 : static_cast<int>(news.alarm.priority());
  });
  title += word_of(first) + ": " + with_subject(first.alarm.subject, first.alarm.message);
  if (notice.news.size() > 1) title += " (and " + std::to_string(notice.news.size() - 1) + " more)";
  return clean_line(title);
}

std::string text_of(const Notice& notice) {
  std::string text;
  for (const auto& news : notice.news) {
    const auto& alarm = news.alarm;
    text += word_of(news) + ": " + clean_line(with_subject(alarm.subject, alarm.message)) + "\n";
    for (const auto& one : alarm.consequences) text += "  hence: " + clean_line(one) + "\n";
    if (is_on_record(notice, alarm))
      text += "  alarm " + std::to_string(alarm.id.value) + ", ";
    else
      text += notice.is_of_record ? "  not on record yet, " : "  ";
    text += alarm.kind + ", since " + to_iso8601(news.since);
    if (news.cleared.ns != 0) text += ", over since " + to_iso8601(news.cleared);
    if (alarm.acknowledged.utc_ns != 0) text += ", seen by " + clean_line(alarm.acknowledged_by);
    text += "\n\n";
  }
  if (notice.news.empty()) text += std::string(kTest) + "\n\n";
  text += "Cell " + clean_line(notice.cell) + ", " + to_iso8601(notice.at) + "\n";
  if (!notice.web_address.empty()) text += notice.web_address + "\n";
  if (!notice.remedy.empty()) text += clean_line(notice.remedy) + "\n";
  return text;
}

}  // namespace driftwise::notify
