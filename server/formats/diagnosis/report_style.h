#pragma once
// The style sheet of the reports that people keep: the visual language of the web GUI (one panel
// colour, four verdict shapes, six series) for a page that must stand by itself, light and dark, on
// a phone and on paper.

#include <string_view>

namespace driftwise::formats {

std::string_view report_style();
// "sha256-..." of report_style(), for the page's content security policy: a style sheet that was
// changed without it is refused by the browser, and by a test before that.
std::string_view report_style_hash();

}  // namespace driftwise::formats
