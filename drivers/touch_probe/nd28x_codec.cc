#include "drivers/touch_probe/nd28x_codec.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <vector>

#include "drivers/transport/words.h"
#include "server/core/reasons.h"
#include "server/core/text/trimmed.h"
#include "server/core/try.h"

namespace driftwise::touch_probe {
namespace {

constexpr char kStartOfText = '\x02';
constexpr double kLargest_mm = 1000;  // no probe of this kind is longer

tl::unexpected<Error> bad_nd28x_reply(const char* expected) {
  return fail(ErrorCode::data_loss, reasons::kBadReply, std::string("expected ") + expected);
}

std::string_view trimmed(std::string_view text) { return driftwise::trimmed(text, " \r\n\x02"); }

bool is_printable(std::string_view text) {
  return std::ranges::all_of(text, [](unsigned char c) { return c >= ' ' && c < 0x7f; });
}

constexpr std::string_view kUnits = "\"?GMRmiU", kSortingMarks = " <=>?", kSeries = " A1SGD2F";

tl::unexpected<Error> shows_another(const std::string& what, const std::string& wanted) {
  return fail(ErrorCode::failed_precondition, reasons::kWrongSetUp,
              "the read-out shows " + what + ": set it to " + wanted);
}

// Columns behind the number: a blank, which a mark of the unit may replace, then unit, sorting and
// series. Blanks at the end may be left out.
struct Columns {
  char unit = ' ', sorting = ' ', series = ' ';
  bool are_known = false;
};
Columns columns_of(std::string_view tail) {
  if (tail.starts_with(' ')) tail.remove_prefix(1);
  const auto at = [tail](std::size_t i) { return i < tail.size() ? tail[i] : ' '; };
  Columns out{at(0), at(1), at(2)};
  const auto is_one_of = [](char mark, std::string_view marks) {
    return marks.find(mark) != std::string_view::npos;
  };
  out.are_known = tail.size() <= 3 && (out.unit == ' ' || is_one_of(out.unit, kUnits)) &&
                  is_one_of(out.sorting, kSortingMarks) && is_one_of(out.series, kSeries);
  return out;
}

Result<void> check_unit(char unit) {
  switch (unit) {
    case ' ':
      return {};
    case '?':
      return fail(ErrorCode::failed_precondition, reasons::kInputError,
                  "the read-out marks its value with ? as faulty: look at the probe's cable, clear "
                  "the message");
    case '"':
      return shows_another("inches", "millimetres");
    case 'm':
    case 'i':
    case 'U':
      return shows_another("a speed", "a length in millimetres");
    default:
      return shows_another("an angle", "a length in millimetres");
  }
}

// S of a read-out with two axes is X1 - X2, A is X1 + X2: one record does not say how many axes
// there are. A is accepted, for it is the present value of a read-out with one.
Result<void> check_series(char series) {
  switch (series) {
    case ' ':
    case 'A':
    case '1':
      return {};
    case 'S':
      return shows_another("MIN of a series, or the difference of two axes", "the present value");
    case 'G':
      return shows_another("MAX of a series", "the present value");
    case 'D':
      return shows_another("DIFF of a series", "the present value");
    case '2':
      return shows_another("its second axis X2", "X1");
    default:
      return shows_another("a function of its two axes", "X1");
  }
}

}  // namespace

Result<double> parse_value(std::string_view reply) {
  constexpr const char* kExpected = "<sign> <millimetres> <unit> <sorting> <series>";
  std::string_view text = trimmed(reply);
  if (text.empty() || !is_printable(text)) return bad_nd28x_reply(kExpected);
  const bool has_digit = std::ranges::any_of(text, [](unsigned char c) { return std::isdigit(c); });
  const bool begins_as_value = text.front() == '+' || text.front() == '-';
  if (!has_digit && !begins_as_value)
    return fail(ErrorCode::failed_precondition, reasons::kInputError,
                "the read-out shows '" + std::string(text) +
                    "' in the place of a value: look at the probe's cable, clear the message");
  if (!begins_as_value) return bad_nd28x_reply(kExpected);
  const bool is_negative = text.front() == '-';
  text = trimmed(text.substr(1));
  const std::size_t end =
      std::min(text.find_first_of(" " + std::string(kUnits)), text.size());  // of the number
  const auto columns = columns_of(text.substr(end));
  if (!columns.are_known) return bad_nd28x_reply(kExpected);
  DRIFTWISE_RETURN_IF_ERROR(check_unit(columns.unit));
  DRIFTWISE_RETURN_IF_ERROR(check_series(columns.series));
  text = text.substr(0, end);
  double value_mm = 0;
  if (text.starts_with('+') || text.starts_with('-') || !transport::read_number(text, value_mm) ||
      !std::isfinite(value_mm) || value_mm > kLargest_mm)
    return bad_nd28x_reply(kExpected);
  return is_negative ? -value_mm : value_mm;
}

Result<std::string> parse_identity(std::string_view reply) {
  std::vector<std::string_view> lines;
  for (std::string_view rest = reply; !rest.empty();) {
    const auto end = std::min(rest.find_first_of("\r\n"), rest.size());
    if (const auto line = trimmed(rest.substr(0, end)); !line.empty()) lines.push_back(line);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  if (lines.size() != kIdentityLines || reply.find(kStartOfText) >= reply.find(lines[0]) ||
      !std::ranges::all_of(lines, is_printable))
    return bad_nd28x_reply("STX and three lines of identity");
  if (!lines[0].starts_with("ND"))
    return fail(ErrorCode::failed_precondition, reasons::kWrongDevice,
                "expected a Heidenhain ND read-out");
  return std::string(lines[0]) + ", " + std::string(lines[1]) + ", " + std::string(lines[2]);
}

}  // namespace driftwise::touch_probe
