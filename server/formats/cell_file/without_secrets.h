#pragma once
// Texts for people outside: a cell file without its secrets, and any text without secrets that are
// known or that show themselves by their form.

#include <string>
#include <string_view>
#include <vector>

namespace driftwise::formats {

inline constexpr std::string_view kRemoved = "[removed]";

// The cell file's keys and values, printed anew: comments are gone. Removed: every value of a key
// that names a password, secret, token, key or passphrase; commands and their arguments; users;
// of an address all but scheme and host. Of a path only the last part stays. A text that is no TOML
// gives one sentence.
std::string cell_file_without_secrets(std::string_view text);

// One value of a cell file as a line of text, for a difference that people read: secrets are
// removed as above, paths and people stay. key: "command", "options.password"; empty: the value
// lists several, "name duty, webhook https://...", and is removed whole where one of them names a
// secret. Removing twice changes nothing.
std::string value_without_secrets(std::string_view key, std::string value);

// Values that are removed from the same cell file: what must appear nowhere else either.
std::vector<std::string> secrets_of_cell_file(std::string_view text);

// Every known value (from 4 bytes on) is replaced, and what looks like a secret: tokens of this
// program (dwt_...), private keys in PEM, "Bearer ...", a password before the host of an address,
// what follows "password=" and the like.
std::string without_secrets(std::string text, const std::vector<std::string>& known);

}  // namespace driftwise::formats
