// What a wide table costs, counted instead of timed: requests for memory and their bytes, and how
// far the text is read.

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>

#include "server/formats/csv/dataset_csv.h"

namespace {
std::atomic<long> requests{0}, bytes{0};
}  // namespace

void* operator new(std::size_t size) {
  ++requests;
  bytes += static_cast<long>(size);
  if (void* memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace driftwise::formats {
namespace {

std::string header_of(std::size_t columns) {
  std::string text = "time_s";
  for (std::size_t i = 1; i < columns; ++i) text += ",c" + std::to_string(i) + "_mm";
  return text + "\n";
}

struct Cost {
  double requests = 0, bytes = 0;
};

Cost cost_of(std::size_t columns) {
  std::string text = header_of(columns);
  for (const char* time : {"1", "2"}) {
    text += time;
    for (std::size_t i = 1; i < columns; ++i) text += ",0.5";
    text += "\n";
  }
  CsvLimits limits;
  limits.columns = columns;
  limits.header_bytes = text.size();
  const long requests_before = requests, bytes_before = bytes;
  const auto data = read_dataset_csv(text, "wide.csv", {}, limits);
  const Cost cost{static_cast<double>(requests - requests_before),
                  static_cast<double>(bytes - bytes_before)};
  EXPECT_TRUE(data) << data.error().message;
  return cost;
}

TEST(WideTableCost, GrowsInProportionToTheColumns) {
  const Cost narrow = cost_of(1000), wide = cost_of(64'000);
  // Tables that double may hold up to twice what they need.
  EXPECT_LT(wide.requests / narrow.requests, 64 * 1.2);
  EXPECT_LT(wide.bytes / narrow.bytes, 64 * 2);
  EXPECT_LT(wide.bytes / 64'000, 2000) << "bytes per column";
}

// The header's line ends where the memory that may be read ends: reading on would be a crash.
TEST(WideTableCost, OfOneThatIsRefusedIsItsHeaderOnly) {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  for (const std::size_t columns : {std::size_t{4097}, std::size_t{60'000}}) {
    const std::string header = header_of(columns);
    const std::size_t readable = (header.size() + page - 1) / page * page, whole = 256 * page;
    void* mapped = ::mmap(nullptr, readable + whole, PROT_READ | PROT_WRITE,
                          MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    ASSERT_NE(mapped, MAP_FAILED);
    char* end = static_cast<char*>(mapped) + readable;
    std::memcpy(end - header.size(), header.data(), header.size());
    ASSERT_EQ(::mprotect(end, whole, PROT_NONE), 0);
    const long bytes_before = bytes;
    const auto data = read_dataset_csv({end - header.size(), header.size() + whole}, "wide.csv");
    const long used = bytes - bytes_before;
    ::munmap(mapped, readable + whole);
    ASSERT_FALSE(data);
    EXPECT_EQ(data.error().reason, "TOO_MANY_COLUMNS");
    EXPECT_LT(used, 2 << 20) << "what 4096 names take, however many there are";
  }
}

}  // namespace
}  // namespace driftwise::formats
