#include "server/formats/csv/dataset_csv.h"

#include <algorithm>

#include "server/core/data/row_marks.h"
#include "server/core/text/clean_text.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {

std::string write_dataset_csv(const Dataset& data) {
  std::string out;
  out.reserve(256 + data.rows * (64 + 20 * data.columns.size()));
  bool has_version = false;
  for (const auto& [key, value] : data.metadata)
    has_version = has_version || key == kDatasetVersionKey;
  if (!has_version) out += "# driftwise-dataset: 1\n";
  for (const auto& [key, value] : data.metadata) {
    out += clean_line(key.empty() ? "# " + value : "# " + key + ": " + value) + "\n";
  }

  const bool any_suspect = std::ranges::find(data.excluded, kSuspectRow) != data.excluded.end();
  const bool any_passage = std::ranges::find(data.excluded, kPassageRow) != data.excluded.end();
  const std::size_t header_start = out.size();
  const auto name = [&](std::string_view text) {
    out.append(out.size() > header_start ? "," : "").append(text);
  };
  if (!data.time_s.empty()) name("time_s");
  if (!data.run.empty()) name("run");
  if (!data.datum.empty()) name("datum");
  if (!data.set.empty()) name("set");
  if (!data.line.empty()) name("line");
  if (!data.zero.empty()) name("zero");
  if (!data.dwell_s.empty()) name("dwell_s");
  if (!data.excluded.empty()) name("excluded");
  if (any_suspect) name("suspect");
  if (any_passage) name("passage");
  for (const auto& column : data.columns) name(column.channel.name());
  out += '\n';

  for (std::size_t row = 0; row < data.rows; ++row) {
    const std::size_t row_start = out.size();
    bool first = true;
    const auto next = [&] {
      if (!first) out += ',';
      first = false;
    };
    if (!data.time_s.empty()) next(), append_number(out, data.time_s[row]);
    if (!data.run.empty()) next(), append_number(out, data.run[row]);
    if (!data.datum.empty()) next(), append_number(out, data.datum[row]);
    if (!data.set.empty())
      next(), out += data.set[row] == PointSet::validation ? "validation" : "calibration";
    if (!data.line.empty()) next(), append_number(out, data.line[row]);
    if (!data.zero.empty()) next(), out += data.zero[row] ? '1' : '0';
    if (!data.dwell_s.empty()) next(), append_number(out, data.dwell_s[row]);
    if (!data.excluded.empty()) next(), out += data.excluded[row] ? '1' : '0';
    if (any_suspect) next(), out += is_suspect(data, row) ? '1' : '0';
    if (any_passage) next(), out += is_passage(data, row) ? '1' : '0';
    for (const auto& column : data.columns) next(), append_number(out, column.values[row]);
    if (out.size() == row_start)
      out += ' ';  // a lone empty field: an empty line would be passed over
    out += '\n';
  }
  return out;
}

}  // namespace driftwise::formats
