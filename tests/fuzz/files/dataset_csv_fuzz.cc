// Any bytes: an error with a place, or a dataset that writes and reads back to the same text.

#include <cstdint>
#include <cstdlib>

#include "server/formats/csv/dataset_csv.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto dataset = formats::read_dataset_csv(text, "fuzz.csv");
  if (!dataset) {
    if (!dataset.error().message.starts_with("fuzz.csv:")) std::abort();
    return 0;
  }
  for (const auto& column : dataset->columns)
    if (column.values.size() != dataset->rows) std::abort();
  const std::string written = formats::write_dataset_csv(*dataset);
  const auto again = formats::read_dataset_csv(written, "again.csv");
  if (!again || formats::write_dataset_csv(*again) != written) std::abort();
  return 0;
}
