// Runs a fuzz harness without libFuzzer: every corpus file as it is, then seeded mutations of them
// and random bytes. Bounded by count, so the same inputs run everywhere: this keeps the harness
// honest in builds without clang.

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes mutate(Bytes bytes, std::mt19937& random) {
  const unsigned changes = 1 + random() % 8;
  for (unsigned i = 0; i < changes; ++i) {
    const std::size_t at = bytes.empty() ? 0 : random() % bytes.size();
    switch (random() % 4) {
      case 0:
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                     static_cast<std::uint8_t>(random()));
        break;
      case 1:
        if (!bytes.empty()) bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at));
        break;
      case 2:
        if (!bytes.empty()) bytes[at] = static_cast<std::uint8_t>(random());
        break;
      default:
        if (!bytes.empty()) bytes.resize(at);
        break;
    }
  }
  return bytes;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<Bytes> corpus{{}};
  for (int i = 1; i < argc; ++i) {
    if (!std::filesystem::is_directory(argv[i])) continue;
    for (const auto& entry : std::filesystem::directory_iterator(argv[i])) {
      std::ifstream file(entry.path(), std::ios::binary);
      corpus.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    }
  }
  std::mt19937 random(20110722);
  std::size_t runs = 0;
  for (const auto& bytes : corpus) LLVMFuzzerTestOneInput(bytes.data(), bytes.size()), ++runs;
  for (int i = 0; i < 3000; ++i) {
    Bytes bytes = corpus[random() % corpus.size()];
    if (bytes.size() > 65536) bytes.resize(65536);
    bytes = mutate(std::move(bytes), random);
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size()), ++runs;
  }
  std::printf("%zu inputs, none crashed\n", runs);
  return 0;
}
