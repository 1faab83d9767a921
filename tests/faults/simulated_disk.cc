#include "tests/faults/simulated_disk.h"

#include <algorithm>
#include <array>

namespace driftwise::faults {
namespace {

bool arrives(double chance, std::mt19937_64& random) {
  // By hand: std::bernoulli_distribution is not the same everywhere.
  return static_cast<double>(random() >> 11) * 0x1.0p-53 < chance;
}

void put(std::string& content, std::uint64_t offset, std::string_view bytes) {
  const std::size_t end = static_cast<std::size_t>(offset) + bytes.size();
  if (content.size() < end) content.resize(end, '\0');  // a gap that never arrived reads as zeros
  std::ranges::copy(bytes, content.begin() + static_cast<std::ptrdiff_t>(offset));
}

}  // namespace

void SimulatedDisk::found(const std::string& path, std::string content) {
  files_[path].bodies = {Body{.exists = true, .content = std::move(content), .unsynced = {}}};
}

void SimulatedDisk::created(const std::string& path) {
  files_[path].bodies.push_back({.exists = true, .content = {}, .unsynced = {}});
}

void SimulatedDisk::removed(const std::string& path) { files_[path].bodies.push_back({}); }

void SimulatedDisk::written(const std::string& path, std::uint64_t offset, std::string_view bytes) {
  files_[path].bodies.back().unsynced.push_back({false, offset, std::string(bytes)});
}

void SimulatedDisk::truncated(const std::string& path, std::uint64_t size) {
  files_[path].bodies.back().unsynced.push_back({true, size, {}});
}

void SimulatedDisk::sync_file(const std::string& path) {
  Body& body = files_[path].bodies.back();
  for (const Change& change : body.unsynced) apply(change, body.content);
  body.unsynced.clear();
}

void SimulatedDisk::sync_folder() {
  for (auto& [path, file] : files_) file.bodies.erase(file.bodies.begin(), file.bodies.end() - 1);
}

void SimulatedDisk::apply(const Change& change, std::string& content) {
  if (change.truncates)
    content.resize(static_cast<std::size_t>(change.offset), '\0');
  else
    put(content, change.offset, change.bytes);
}

std::string SimulatedDisk::torn(const Body& body, std::size_t sector_bytes, double chance,
                                std::mt19937_64& random) {
  std::string content = body.content;
  for (const Change& change : body.unsynced) {
    if (change.truncates) {
      if (arrives(chance, random)) apply(change, content);
      continue;
    }
    const std::string_view bytes = change.bytes;
    for (std::size_t begin = 0; begin < bytes.size();) {
      const std::uint64_t at = change.offset + begin;
      const std::size_t to_border = sector_bytes - static_cast<std::size_t>(at % sector_bytes);
      const std::size_t size = std::min(to_border, bytes.size() - begin);
      if (arrives(chance, random)) put(content, at, bytes.substr(begin, size));
      begin += size;
    }
  }
  return content;
}

std::map<std::string, std::string> SimulatedDisk::after(const PowerCut& cut) const {
  std::mt19937_64 random(cut.seed);
  // Few, half or most sectors arrive: a lone loss and a lone survivor are both likely.
  constexpr std::array<double, 4> kChances = {0.05, 0.5, 0.9, 0.98};
  const double chance = kChances.at(random() % kChances.size());
  std::map<std::string, std::string> left;
  for (const auto& [path, file] : files_) {
    // A folder's changes arrive in order (file systems keep a journal of them), up to somewhere.
    std::size_t which = cut.survivors == Survivors::all ? file.bodies.size() - 1 : 0;
    if (cut.survivors == Survivors::random)
      which = static_cast<std::size_t>(random() % file.bodies.size());
    const Body& body = file.bodies[which];
    if (!body.exists) continue;
    const double arriving = cut.survivors == Survivors::none  ? 0.0
                            : cut.survivors == Survivors::all ? 1.0
                                                              : chance;
    left[path] = torn(body, cut.sector_bytes, arriving, random);
  }
  return left;
}

}  // namespace driftwise::faults
