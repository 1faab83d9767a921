#pragma once
// The bytes of series_block: a stretch of one channel, whole or summarised. Pure.
//
// Level 0 keeps every value: blocks of 256 s, each n (u32), then n instants as microseconds after
// the block's start (u32), then n values (f64), by instant. Level k >= 1 keeps buckets of 8 s x
// 4^(k-1), 256 to a block: per bucket count (f64), minimum, maximum and sum. Numbers lie as the
// machine has them (little-endian). A value belongs to the bucket its instant falls into, bounds
// being multiples of the length since 1970. Adding is a union, so that order and repetition of
// steps do not matter as long as each reading is added once.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace driftwise::storage {

struct Sample {
  std::int64_t at_ns;
  double value;  // never missing
};

struct Bucket {
  double count = 0, min = 0, max = 0, sum = 0;
  void add(double value) { add({1, value, value, value}); }
  void add(const Bucket& other) {
    if (other.count == 0) return;
    min = count == 0 || other.min < min ? other.min : min;
    max = count == 0 || other.max > max ? other.max : max;
    sum += other.sum;
    count += other.count;
  }
};

constexpr int kSummaryLevels = 5;  // 8, 32, 128, 512, 2048 s
constexpr std::int64_t kBucketsPerBlock = 256;
constexpr std::int64_t kRawBlockNs = 256'000'000'000;

constexpr std::int64_t bucket_ns(int level) {  // level >= 1
  std::int64_t out = 8'000'000'000;
  for (int k = 1; k < level; ++k) out *= 4;
  return out;
}
constexpr std::int64_t block_ns(int level) {
  return level == 0 ? kRawBlockNs : bucket_ns(level) * kBucketsPerBlock;
}
// The largest multiple of length that is not above t; t may be negative.
constexpr std::int64_t floor_to(std::int64_t t, std::int64_t length) {
  const std::int64_t rest = t % length;
  return t - (rest < 0 ? rest + length : rest);
}

// data: a block's bytes, or empty for a new one; samples: all of this block. Bytes of any other
// length than a block's are taken for damage and throw StorageFailure data_loss.
std::string add_samples(std::string_view data, std::int64_t start_ns,
                        std::span<const Sample> samples);
std::string add_to_buckets(std::string_view data, int level, std::int64_t start_ns,
                           std::span<const Sample> samples);

std::vector<Sample> samples_of(std::string_view data, std::int64_t start_ns);
std::array<Bucket, kBucketsPerBlock> buckets_of(std::string_view data);

}  // namespace driftwise::storage
