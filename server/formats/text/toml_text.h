#pragma once
// TOML text from outside, parsed with a limit on its depth.
//
// toml++ 3.3 limits values in values, but neither dotted keys nor dotted headers, and it ends a
// parse and destroys a table by recursion: 64 kB of dots overflow the stack. The levels are
// therefore counted before toml++ gets the text.

#include <toml++/toml.h>

#include <cstddef>
#include <string_view>

namespace driftwise::formats {

// Ours have six.
inline constexpr std::size_t kMostTomlLevels = 100;

// The only caller of toml::parse() in server and clients.
// Throws toml::parse_error for a syntax error, and where a value would lie more than
// kMostTomlLevels deep: parts of the header, parts of the keys, lists and tables in braces
// together.
toml::table parse_toml(std::string_view text, std::string_view file_name = {});

}  // namespace driftwise::formats
