#pragma once
// Text that can be shown on a terminal, in a log and in a list: the one place that cleans text at
// each door (docs/api.md, "Text"). Any thread.
//
// Replaced by '?': bytes that are no UTF-8; the control characters U+0000..U+001F, U+007F and
// U+0080..U+009F, which terminals obey; the characters that turn the direction of a line (U+061C,
// U+200E, U+200F, U+202A..U+202E, U+2066..U+2069) and annotation marks (U+FFF9..U+FFFB).
// Sources: ECMA-48 (control functions); Unicode 15, UAX #9 (bidirectional formatting).

#include <string>
#include <string_view>

namespace driftwise {

// One line: a name, a reason, a message in a table. Tabs and every kind of line end (LF, CR,
// U+0085, U+2028, U+2029) become blanks.
std::string clean_line(std::string_view text);

// Several lines: a note, a file. Tabs, LF and CR LF stay as they are.
std::string clean_text(std::string_view text);

}  // namespace driftwise
