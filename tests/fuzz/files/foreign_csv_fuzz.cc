// Any bytes as another program's table, by a mapping that uses every rule: an error with its place,
// or a dataset that writes and reads back.

#include <cstdint>
#include <cstdlib>

#include "server/formats/csv/dataset_csv.h"
#include "server/formats/import/import_dataset.h"
#include "server/formats/import/mapping_file.h"

namespace {

using driftwise::formats::ImportMapping;

ImportMapping mapping_of_everything() {
  constexpr const char* kText =
      "[file]\nseparator = \";\"\ndecimal = \",\"\nthousands = \".\"\nmissing = [\"\", \"-999\"]\n"
      "[time]\ncolumn = \"t\"\nformat = \"iso8601\"\norder = \"by-time\"\nequal_times = "
      "\"spread\"\nresolution_s = 0.5\n"
      "[[column]]\nsource = \"pos\"\nunit = \"m\"\nchannel = \"x_mm\"\n"
      "[[column]]\nsource = \"temp\"\nunit = \"K\"\nchannel = \"t01_degC\"\n"
      "[[drop]]\ncolumn = \"q\"\nequals = \"bad\"\nwhy = \"said so\"\n"
      "[[drop]]\ncolumn = \"pos\"\nabove = 1000\nwhy = \"far away\"\n"
      "[[pose]]\nposition = [\"x_mm\", \"x_mm\", \"x_mm\"]\ninto_position = [\"a_mm\", \"b_mm\", "
      "\"c_nm\"]\n[pose.frame]\ntranslation_mm = [1, 2, 3]\nrotation_deg = [10, 20, 30]\n"
      "[group]\nchannels = [\"x_mm\"]\nwithin = 0.5\n[sets]\nvalidation_share = 0.3\n";
  return *driftwise::formats::read_import_mapping(kText, "everything.toml");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace driftwise;
  static const ImportMapping mapping = mapping_of_everything();
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto imported = formats::import_dataset(bytes, "fuzz.csv", mapping);
  if (!imported) {
    if (!imported.error().message.starts_with("fuzz.csv:")) std::abort();
    return 0;
  }
  const Dataset& dataset = imported->dataset;
  for (const auto& column : dataset.columns)
    if (column.values.size() != dataset.rows) std::abort();
  if (dataset.line.size() != dataset.rows || dataset.set.size() != dataset.rows) std::abort();
  const std::string written = formats::write_dataset_csv(dataset);
  const auto again = formats::read_dataset_csv(written, "again.csv");
  if (!again || formats::write_dataset_csv(*again) != written) std::abort();
  return 0;
}
