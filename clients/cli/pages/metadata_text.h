#pragma once
// "sample=A12" on the command line -> an item of metadata.

#include <string>
#include <vector>

#include "clients/cli/core/console.h"
#include "driftwise/v1/run.pb.h"

namespace driftwise::cli {

// Throws Failure (usage) naming a text without "=". What a key and a value may be is the daemon's
// to say.
inline std::vector<v1::MetadataItem> metadata_from(const std::vector<std::string>& texts) {
  std::vector<v1::MetadataItem> items;
  for (const auto& text : texts) {
    const auto equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      throw Failure{ExitCode::usage, "usage", "USAGE",
                    "metadata: found '" + text + "', expected key=value: sample=A12"};
    auto& item = items.emplace_back();
    item.set_key(text.substr(0, equals));
    item.set_value(text.substr(equals + 1));
  }
  return items;
}

template <class Items>
std::string metadata_text(const Items& items) {
  std::string text;
  for (const auto& item : items)
    text += (text.empty() ? "" : ", ") + item.key() + "=" + item.value();
  return text;
}

}  // namespace driftwise::cli
