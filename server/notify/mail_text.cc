#include "server/notify/mail_text.h"

#include <algorithm>
#include <array>
#include <ctime>

#include "server/core/text/clean_text.h"

namespace driftwise::notify {
namespace {

std::string base64_of(std::string_view bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t j = 0; j < 3; ++j)
      group = group << 8 | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0U);
    for (std::size_t j = 0; j < 4; ++j)
      text += i + j <= bytes.size() ? kDigits[group >> (18 - 6 * j) & 0x3F] : '=';
  }
  return text;
}

std::string subject_line(const std::string& subject) {
  const std::string plain = clean_line(subject);
  const bool ascii = std::ranges::all_of(plain, [](char c) { return c >= ' ' && c <= '~'; });
  if (ascii && plain.size() <= 900) return plain;
  // At most 75 characters for an encoded word, cut between characters of UTF-8.
  constexpr std::size_t kMostBytes = 42;
  std::string line;
  for (std::size_t at = 0; at < plain.size();) {
    std::size_t end = std::min(plain.size(), at + kMostBytes);
    while (end < plain.size() && (static_cast<unsigned char>(plain[end]) & 0xC0) == 0x80) --end;
    line += (line.empty() ? "=?UTF-8?B?" : "\r\n =?UTF-8?B?") +
            base64_of(std::string_view(plain).substr(at, end - at)) + "?=";
    at = end;
  }
  return line;
}

std::string date_of(std::int64_t unix_s) {
  constexpr std::array kDays = {"Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"};
  constexpr std::array kMonths = {"Jan", "Feb", "Mar", "Apr", "May", "Jun",
                                  "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};
  const std::time_t time = unix_s;
  std::tm parts{};
  gmtime_r(&time, &parts);
  const auto two = [](int value) {
    return std::string(value < 10 ? "0" : "") + std::to_string(value);
  };
  return std::string(kDays[static_cast<std::size_t>(parts.tm_wday)]) + ", " + two(parts.tm_mday) +
         " " + kMonths[static_cast<std::size_t>(parts.tm_mon)] + " " +
         std::to_string(parts.tm_year + 1900) + " " + two(parts.tm_hour) + ":" + two(parts.tm_min) +
         ":" + two(parts.tm_sec) + " +0000";
}

}  // namespace

std::string rfc5322(const Mail& mail) {
  std::string to;
  for (const auto& one : mail.to) to += (to.empty() ? "" : ",\r\n ") + one;
  std::string text = "From: " + mail.from + "\r\nTo: " + to +
                     "\r\nSubject: " + subject_line(mail.subject) +
                     "\r\nDate: " + date_of(mail.unix_s) + "\r\nMessage-ID: <" + mail.message_id +
                     ">\r\nAuto-Submitted: auto-generated\r\nMIME-Version: 1.0\r\n"
                     "Content-Type: text/plain; charset=utf-8\r\n"
                     "Content-Transfer-Encoding: base64\r\n\r\n";
  const std::string body = base64_of(mail.text);
  for (std::size_t at = 0; at < body.size(); at += 76) text += body.substr(at, 76) + "\r\n";
  return text;
}

}  // namespace driftwise::notify
