#include "storage/chain/thinned_entry.h"

#include <algorithm>

#include "storage/chain/value_bytes.h"

namespace driftwise::storage {
namespace {

constexpr std::size_t kMostStretchesTold = 20;

std::string readings_text(const ThinnedEntry& entry) {
  return std::to_string(entry.count) + " readings of " + std::to_string(entry.first) + " to " +
         std::to_string(entry.last());
}

}  // namespace

bool ThinnedEntry::holds(std::int64_t reading) const {
  if (reading < first || reading > last()) return false;
  const auto at = static_cast<std::uint64_t>(reading - first);
  return ((static_cast<unsigned char>(bits[at / 8]) >> (at % 8)) & 1U) != 0;
}

std::string thinned_bytes(std::int64_t thinning, std::span<const std::int64_t> readings,
                          std::string_view hash) {
  std::string bits(static_cast<std::size_t>((readings.back() - readings.front()) / 8 + 1), '\0');
  for (const std::int64_t reading : readings) {
    const auto at = static_cast<std::uint64_t>(reading - readings.front());
    bits[at / 8] = static_cast<char>(static_cast<unsigned char>(bits[at / 8]) | (1U << (at % 8)));
  }
  std::string bytes;
  add_integer(bytes, thinning);
  add_integer(bytes, kReadingKind);
  add_integer(bytes, static_cast<std::int64_t>(readings.size()));
  add_integer(bytes, readings.front());
  bytes += hash;
  add_blob(bytes, bits);
  return bytes;
}

std::optional<ThinnedEntry> thinned_from(std::string_view bytes) {
  BytesReader reader(bytes);
  ThinnedEntry out;
  out.thinning = reader.integer();
  const std::int64_t kind = reader.integer();
  out.count = reader.integer();
  out.first = reader.integer();
  out.hash = reader.fixed(digest::kSha256Bytes);
  const std::string_view blob = reader.value();
  if (!reader.good() || !reader.at_end() || kind != kReadingKind || blob.empty()) return {};
  BytesReader inside(blob);
  inside.fixed(1);
  const std::int64_t size = inside.integer();
  out.bits = inside.fixed(static_cast<std::size_t>(size));
  constexpr std::int64_t kMostId = std::int64_t{1} << 60;  // a sum of two still is a number
  if (!inside.good() || out.bits.empty() || out.first < 0 || out.first > kMostId) return {};
  return out;
}

void ThinnedStretches::read(Database& db) {
  Query query(db,
              "SELECT entry_id, bytes FROM chain WHERE what = 'thinned' AND entry_id > ? ORDER BY "
              "entry_id");
  query.bind(read_up_to_);
  while (query.row()) {
    read_up_to_ = query.integer(0);
    auto entry = thinned_from(query.bytes(1));
    if (!entry) continue;  // the chain's own check names an entry that was changed
    by_last_.emplace(entry->last(), read_up_to_);
    longest_ = std::max(longest_, entry->last() - entry->first);
    Stretch& stretch = stretches_[read_up_to_];
    stretch.entry = std::move(*entry);
    stretch.compared = first_;
    stretch.sha.begin();
  }
  first_ = false;
}

const ThinnedEntry* ThinnedStretches::take(std::int64_t reading, std::string_view digest) {
  for (auto at = by_last_.lower_bound(reading);
       at != by_last_.end() && at->first <= reading + longest_; ++at) {
    Stretch& stretch = stretches_.at(at->second);
    if (!stretch.entry.holds(reading)) continue;
    ++stretch.seen;
    stretch.sha.add(digest);
    return &stretch.entry;
  }
  return nullptr;
}

std::vector<std::string> ThinnedStretches::differences(std::int64_t since) {
  std::vector<std::string> out;
  for (auto& [number, stretch] : stretches_) {
    if (!stretch.compared || number < since) continue;
    if (stretch.seen == stretch.entry.count && stretch.sha.finish() == stretch.entry.hash) continue;
    out.push_back("the stretch that thinning " + std::to_string(stretch.entry.thinning) +
                  " removed (" + readings_text(stretch.entry) +
                  ") was changed before it was thinned: its digests are not those of the chain");
  }
  return out;
}

void ThinnedStretches::tell(Database& db, ChainReport& report) const {
  // The instant in UTC: cell time plus the offset of the last row of `clock` before it.
  Query query(db,
              "SELECT who, at_ns + COALESCE((SELECT offset_ns FROM clock WHERE from_ns <= at_ns "
              "ORDER BY clock_id DESC LIMIT 1), 0), reducer, every_ns, hash FROM thinning WHERE "
              "thinning_id = ?");
  for (const auto& [number, stretch] : stretches_) {
    report.thinned_readings += stretch.entry.count;
    if (report.thinned.size() >= kMostStretchesTold) continue;
    std::string sentence = "thinned: " + readings_text(stretch.entry);
    query.bind(stretch.entry.thinning);
    if (query.row())
      sentence += " by " + query.text(0) + " at " + to_iso8601(CellTime{query.integer(1)}) + ", " +
                  query.text(2) + " every " + std::to_string(query.integer(3) / 1'000'000'000) +
                  " s";
    query.restart();
    report.thinned.push_back(sentence + ", hash " + digest::hex_from(stretch.entry.hash));
  }
}

}  // namespace driftwise::storage
