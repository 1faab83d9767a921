#pragma once
// Small pieces that every text format of this room shares.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/text/shown_text.h"

namespace driftwise::formats {

// Shortest digits that read back as the same double; nothing for NaN and the infinities (an empty
// field).
void append_number(std::string& out, double value);
void append_number(std::string& out, std::int64_t value);
using driftwise::number_text;
using driftwise::shown;

// "drift.csv:7: "
std::string at_line(std::string_view file_name, std::size_t line);

// The known word nearest to the found one, when it is near enough to be meant; "" otherwise.
std::string nearest_word(std::string_view found, const std::vector<std::string_view>& known);

// Identifies a text (cell file, dataset, model): SHA-256, 64 hexadecimal digits.
std::string content_hash(std::string_view text);
// The same as programs before wrote it, in the form of a stored one: one of 16 digits is FNV-1a, 64
// bit (draft-eastlake-fnv), which is no protection against somebody who forges a text.
std::string content_hash_like(std::string_view stored, std::string_view text);

}  // namespace driftwise::formats
