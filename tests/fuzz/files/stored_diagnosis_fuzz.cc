// Any bytes in the database's columns of a diagnosis: an error, or a diagnosis that writes and
// reads back to the same text, and rows that do. What reads may be shown, exported and plotted:
// none of it may crash. An input is the text, a zero byte, and the rows.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string_view>

#include "server/formats/diagnosis/diagnosis_html.h"
#include "server/formats/diagnosis/diagnosis_json.h"
#include "server/formats/diagnosis/stored_diagnosis.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  const std::string_view whole(reinterpret_cast<const char*>(data), size);
  const auto middle = std::min(whole.find('\0'), whole.size());
  const auto text = whole.substr(0, middle);
  const auto bytes = middle < whole.size() ? whole.substr(middle + 1) : whole;

  const auto rows = formats::read_discrepancy_rows(bytes);
  if (rows) {
    const std::string written = formats::write_discrepancy_rows(*rows);
    const auto again = formats::read_discrepancy_rows(written);
    if (!again || formats::write_discrepancy_rows(*again) != written) std::abort();
  }
  auto diagnosis = formats::read_stored_diagnosis(text);
  if (!diagnosis) return 0;
  const std::string written = formats::write_stored_diagnosis(*diagnosis);
  const auto again = formats::read_stored_diagnosis(written);
  if (!again || formats::write_stored_diagnosis(*again) != written) std::abort();
  (void)formats::diagnosis_json(*diagnosis).dump();
  (void)formats::diagnosis_page(*diagnosis);
  if (!rows) return 0;
  const Dataset dataset = formats::dataset_of(*rows, *diagnosis);
  (void)formats::diagnosis_html(*diagnosis, dataset, {"Diagnosis 1", "run 1"});
  return 0;
}
