#include "server/application/provenance/configuration_book.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/core/try.h"

namespace driftwise::application {
namespace {

constexpr std::size_t kMostNamed = 4;

}  // namespace

std::string list_of(const std::vector<formats::ConfigurationChange>& changes, std::size_t most) {
  std::string text;
  for (std::size_t i = 0; i < changes.size() && i < most; ++i)
    text += (text.empty() ? "" : "; ") + formats::sentence(changes[i]);
  if (changes.size() > most) text += fmt::format("; and {} more", changes.size() - most);
  return text;
}

std::vector<formats::ConfigurationChange> touching(
    const std::vector<formats::ConfigurationChange>& changes,
    const std::vector<std::string>& symbols) {
  std::vector<formats::ConfigurationChange> found;
  for (const auto& change : changes)
    if (change.asks && std::ranges::any_of(change.affects, [&](const std::string& symbol) {
          return std::ranges::find(symbols, symbol) != symbols.end();
        }))
      found.push_back(change);
  return found;
}

Result<ConfigurationBook> ConfigurationBook::open(Store& writing, const CellDescription& cell,
                                                  const std::string& version, Stamp now) {
  ConfigurationBook book;
  DRIFTWISE_TRY(const auto before, writing.configurations().accepted_hash());
  ConfigurationStart start;
  start.hash = cell.hash;
  start.version = version;
  start.at = now;
  if (before) {
    start.before_hash = *before;
    if (*before != cell.hash) {
      DRIFTWISE_TRY(const auto text, writing.configurations().text(*before));
      book.changes_ = formats::cell_file_difference(text, cell);
    }
  }
  start.asks = formats::any_asks(book.changes_);
  start.changes_json = formats::write_changes_json(book.changes_);
  DRIFTWISE_TRY(auto stored, writing.configurations().begin(start, cell.text));
  book.start_ = std::move(stored);
  return book;
}

std::string ConfigurationBook::question() const {
  if (!asks()) return {};
  std::vector<formats::ConfigurationChange> asking;
  std::ranges::copy_if(changes_, std::back_inserter(asking), &formats::ConfigurationChange::asks);
  return fmt::format(
      "the cell file has changed since configuration {}: {}. Look at it and accept it ('driftwise "
      "configuration accept'), or put the file back and start the daemon again",
      start_.before_hash, list_of(asking, kMostNamed));
}

std::string ConfigurationBook::question_for(const RunRecord& run) const {
  if (!asks() || run.created >= start_.at.utc) return {};
  return question();
}

std::string ConfigurationBook::event() const {
  if (start_.before_hash.empty())
    return fmt::format("configuration {} is in force, the first on this database", start_.hash);
  if (start_.before_hash == start_.hash)
    return fmt::format("configuration {} is in force, as before", start_.hash);
  if (changes_.empty())
    return fmt::format("configuration {} is in force: the same by meaning as {}", start_.hash,
                       start_.before_hash);
  return fmt::format("configuration {} is in force after {}: {}{}", start_.hash, start_.before_hash,
                     list_of(changes_, 20), start_.asks ? ". A person has to accept it" : "");
}

std::string ConfigurationBook::changes_of(const std::vector<std::string>& symbols) const {
  if (!asks()) return {};
  return list_of(touching(changes_, symbols), kMostNamed);
}

}  // namespace driftwise::application
