#include "server/application/provenance/stored_description.h"

#include "server/formats/cell_file/cell_file.h"

namespace driftwise::application {

namespace {

constexpr const char* kAnyPath = "cell.toml";  // paths inside the file do not matter here

}  // namespace

std::optional<CellDescription> stored_description(Store& store, const std::string& hash,
                                                  const CellDescription& present) {
  if (hash == present.hash) return present;
  const auto text = store.configurations().text(hash);
  if (!text) return std::nullopt;
  auto cell = formats::parse_cell_file(*text, kAnyPath, present.kinds);
  if (!cell) return std::nullopt;
  return std::move(*cell);
}

}  // namespace driftwise::application
