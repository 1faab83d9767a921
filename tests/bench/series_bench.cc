// What a long run costs to look at: 60 hours of 30 channels at 1 Hz, 6.5 million values.
//
//   series_bench [folder] [hours]     prints one JSON object; default: the current folder, 60
//
// open: the whole record, 30 channels in 1600 buckets. zoom: 200 windows between 60 s and the
// whole, seeded, anywhere in it. Both by the port (SQLite and arithmetic, without the wire), first
// after the file was opened anew. keep_up: one step of the summaries, which a point may have to
// wait for.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/storage/store_fixture.h"

namespace {

using namespace driftwise;
using storage::at_s;
using WallClock = std::chrono::steady_clock;

constexpr int kChannels = 30, kBuckets = 1600;

double milliseconds_since(WallClock::time_point begin) {
  return std::chrono::duration<double, std::milli>(WallClock::now() - begin).count();
}

double quantile_of(std::vector<double> values, double p) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(p * static_cast<double>(values.size() - 1))];
}

std::string channel_of(int i) { return "t" + std::to_string(i) + "_degC"; }

void fill(Store& store, std::int64_t seconds) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0, 0.01);
  std::vector<Reading> batch;
  for (std::int64_t s = 0; s < seconds; ++s) {
    Reading reading{"scanner", at_s(static_cast<double>(s)).utc, {}, s, {}};
    reading.end = reading.start;
    for (int i = 0; i < kChannels; ++i)
      reading.values.push_back({channel_of(i), 20 + noise(random)});
    batch.push_back(std::move(reading));
    if (batch.size() < 1000 && s + 1 < seconds) continue;
    if (!store.readings().append(batch, {})) std::abort();
    batch.clear();
  }
}

double look(Store& store, double from_s, double to_s) {
  SeriesQuery query;
  for (int i = 0; i < kChannels; ++i) query.channels.push_back(channel_of(i));
  query.from = at_s(from_s).utc;
  query.to = at_s(to_s).utc;
  query.buckets = kBuckets;
  const auto begin = WallClock::now();
  const auto answer = store.series().series(query);
  const double ms = milliseconds_since(begin);
  if (!answer || answer->columns.size() != kChannels) std::abort();
  return ms;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string folder = argc > 1 ? argv[1] : ".";
  const double hours = argc > 2 ? std::stod(argv[2]) : 60;
  const auto seconds = static_cast<std::int64_t>(hours * 3600);
  const std::string path = folder + "/series_bench.db";
  for (const char* ending : {"", "-wal", "-shm", ".lock"}) std::filesystem::remove(path + ending);

  nlohmann::ordered_json out = {{"hours", hours}, {"values", seconds * kChannels}};
  std::vector<double> steps;
  {
    auto store = storage::open_store(path);
    fill(*store, seconds);
    if (!store->idle()) std::abort();
    out["bytes_before"] = std::filesystem::file_size(path);
    for (bool more = true; more;) {
      const auto begin = WallClock::now();
      more = store->series().summarise().value();
      steps.push_back(milliseconds_since(begin));
    }
    if (!store->idle()) std::abort();
    out["bytes_with_summaries"] = std::filesystem::file_size(path);
  }
  out["keep_up_ms"] = {{"p50", quantile_of(steps, 0.5)}, {"max", quantile_of(steps, 1)}};

  auto store = storage::open_store(path, true);
  out["open_ms"] = {{"first", look(*store, 0, static_cast<double>(seconds))},
                    {"again", look(*store, 0, static_cast<double>(seconds))}};
  std::mt19937_64 random(2);
  std::vector<double> zooms;
  for (int i = 0; i < 200; ++i) {
    const double share = static_cast<double>(random() % 1000) / 1000;
    const double length = 60 * std::pow(static_cast<double>(seconds) / 60, share);
    const double from =
        static_cast<double>(random() % 1000) / 1000 * (static_cast<double>(seconds) - length);
    zooms.push_back(look(*store, from, from + length));
  }
  out["zoom_ms"] = {{"p50", quantile_of(zooms, 0.5)},
                    {"p95", quantile_of(zooms, 0.95)},
                    {"max", quantile_of(zooms, 1)}};
  std::puts(out.dump(2).c_str());
  store.reset();
  for (const char* ending : {"", "-wal", "-shm", ".lock"}) std::filesystem::remove(path + ending);
  return 0;
}
