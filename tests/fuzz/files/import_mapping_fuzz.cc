// Any bytes as a mapping file: an error with its place, or a mapping that a small table survives.

#include <cstdint>
#include <cstdlib>

#include "server/formats/import/import_dataset.h"
#include "server/formats/import/mapping_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto mapping = formats::read_import_mapping(text, "fuzz.toml");
  if (!mapping) {
    if (!mapping.error().message.starts_with("fuzz.toml:")) std::abort();
    return 0;
  }
  for (const char* table : {"Timestamp;x;d;t\n20200714163904;1,5;21.11.2026;08:00:00\n",
                            "1 2 3\n4 5 6\n", "a,b\n1,2\n"}) {
    const auto imported = formats::import_dataset(table, "table.csv", *mapping);
    if (!imported && !imported.error().message.starts_with("table.csv:")) std::abort();
  }
  return 0;
}
