#include "storage/readings/series_block.h"

#include <algorithm>
#include <cstring>

#include "server/core/reasons.h"
#include "storage/sqlite/failure.h"

namespace driftwise::storage {
namespace {

constexpr std::size_t kSampleBytes = sizeof(std::uint32_t) + sizeof(double);
constexpr std::int64_t kNsPerTick = 1000;

[[noreturn]] void damaged(std::string_view data) {
  throw_failure(ErrorCode::data_loss, reasons::kDatabaseDamaged,
                "series_block holds " + std::to_string(data.size()) +
                    " bytes that are no block: empty series_block and set series_mark to 0, and "
                    "the daemon makes it again");
}

}  // namespace

std::vector<Sample> samples_of(std::string_view data, std::int64_t start_ns) {
  std::vector<Sample> out;
  if (data.empty()) return out;
  std::uint32_t count = 0;
  if (data.size() < sizeof count) damaged(data);
  std::memcpy(&count, data.data(), sizeof count);
  if (data.size() != sizeof count + count * kSampleBytes) damaged(data);
  const char* ticks = data.data() + sizeof count;
  const char* values = ticks + count * sizeof(std::uint32_t);
  out.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t tick = 0;
    std::memcpy(&tick, ticks + i * sizeof tick, sizeof tick);
    out[i].at_ns = start_ns + static_cast<std::int64_t>(tick) * kNsPerTick;
    std::memcpy(&out[i].value, values + i * sizeof(double), sizeof(double));
  }
  return out;
}

std::string add_samples(std::string_view data, std::int64_t start_ns,
                        std::span<const Sample> samples) {
  std::vector<Sample> all = samples_of(data, start_ns);
  const auto joint = static_cast<std::ptrdiff_t>(all.size());
  all.insert(all.end(), samples.begin(), samples.end());
  std::ranges::stable_sort(all.begin() + joint, all.end(), {}, &Sample::at_ns);
  std::ranges::inplace_merge(all, all.begin() + joint, {}, &Sample::at_ns);
  const auto count = static_cast<std::uint32_t>(all.size());
  std::string out(sizeof count + count * kSampleBytes, '\0');
  std::memcpy(out.data(), &count, sizeof count);
  char* ticks = out.data() + sizeof count;
  char* values = ticks + count * sizeof(std::uint32_t);
  for (std::size_t i = 0; i < count; ++i) {
    const auto tick = static_cast<std::uint32_t>((all[i].at_ns - start_ns) / kNsPerTick);
    std::memcpy(ticks + i * sizeof tick, &tick, sizeof tick);
    std::memcpy(values + i * sizeof(double), &all[i].value, sizeof(double));
  }
  return out;
}

std::array<Bucket, kBucketsPerBlock> buckets_of(std::string_view data) {
  std::array<Bucket, kBucketsPerBlock> out{};
  if (data.empty()) return out;
  if (data.size() != sizeof out) damaged(data);
  std::memcpy(out.data(), data.data(), sizeof out);
  return out;
}

std::string add_to_buckets(std::string_view data, int level, std::int64_t start_ns,
                           std::span<const Sample> samples) {
  auto buckets = buckets_of(data);
  for (const Sample& sample : samples)
    buckets[static_cast<std::size_t>((sample.at_ns - start_ns) / bucket_ns(level))].add(
        sample.value);
  return {reinterpret_cast<const char*>(buckets.data()), sizeof buckets};
}

}  // namespace driftwise::storage
