#include "server/formats/text/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "server/digest/sha256.h"

namespace driftwise::formats {
namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

}  // namespace

void append_number(std::string& out, double value) {
  if (!std::isfinite(value)) return;
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  out.append(digits, end);
}

void append_number(std::string& out, std::int64_t value) {
  char digits[24];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  out.append(digits, end);
}

std::string at_line(std::string_view file_name, std::size_t line) {
  return std::string(file_name) + ":" + std::to_string(line) + ": ";
}

std::string nearest_word(std::string_view found, const std::vector<std::string_view>& known) {
  std::string_view best;
  std::size_t best_distance = 1 + std::max<std::size_t>(1, found.size() / 3);
  if (found.size() > 64) return {};  // no slip of the pen, and quadratic in length
  for (const auto word : known) {
    const std::size_t distance = edit_distance(found, word);
    // Of two that are as near, the one that begins alike: t1 is t01 rather than q1.
    const bool as_near = distance == best_distance && !best.empty() && !found.empty() &&
                         !word.empty() && best.front() != found.front() &&
                         word.front() == found.front();
    if (distance < best_distance || as_near) {
      best = word;
      best_distance = distance;
    }
  }
  return std::string(best);
}

std::string content_hash(std::string_view text) { return digest::sha256_hex(text); }

std::string content_hash_like(std::string_view stored, std::string_view text) {
  constexpr std::size_t kOlderDigits = 16;
  if (stored.size() != kOlderDigits) return content_hash(text);
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 0x100000001b3u;
  }
  char hex[17];
  std::snprintf(hex, sizeof hex, "%016llx", static_cast<unsigned long long>(hash));
  return hex;
}

}  // namespace driftwise::formats
