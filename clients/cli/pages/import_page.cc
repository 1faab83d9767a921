#include "clients/cli/pages/import_page.h"

#include <algorithm>

#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/text/text.h"

namespace driftwise::cli {
namespace {

std::string comma_list(const std::vector<std::string>& words) {
  std::string out;
  for (const auto& word : words) out += (out.empty() ? "" : ", ") + word;
  return out;
}

std::string lines_text(const std::vector<std::size_t>& lines, std::size_t rows) {
  std::string out;
  for (const std::size_t line : lines) out += (out.empty() ? "" : ", ") + std::to_string(line);
  return (lines.size() == 1 ? "line " : "lines ") + out + (lines.size() < rows ? ", ..." : "");
}

nlohmann::ordered_json number_or_null(double value) {
  return is_missing(value) ? nlohmann::ordered_json() : nlohmann::ordered_json(value);
}

}  // namespace

void print_import(std::ostream& out, const Paint& paint, const formats::ImportReport& report) {
  out << report.rows_read << " rows read, " << report.rows_kept << " kept: " << report.calibration
      << " calibration, " << report.validation << " validation\n";
  for (const auto& dropped : report.dropped)
    if (dropped.rows > 0)
      out << "  " << paint.warn("left out") << ' ' << dropped.rows << ": " << dropped.why << " ("
          << lines_text(dropped.lines, dropped.rows) << ")\n";
  if (!report.time_zero.empty()) out << "  time_s counts from " << report.time_zero << '\n';
  if (report.late_rows > 0)
    out << "  " << paint.warn("put in order of time") << ": " << report.late_rows
        << " rows stood after later ones\n";
  if (report.spread_rows > 0)
    out << "  " << report.spread_rows << " rows share a stamp with the one before: spread\n";
  if (report.groups > 0)
    out << "  " << report.groups << " groups of " << report.smallest_group << " to "
        << report.largest_group << " rows, median " << formats::number_text(report.median_group)
        << '\n';
  if (!report.unused.empty())
    out << "  columns that no rule reads: " << comma_list(report.unused) << '\n';
  out << '\n';
  Table table({{"source", Align::left},
               {"unit", Align::left},
               {"channel", Align::left},
               {"first field", Align::right},
               {"min", Align::right},
               {"max", Align::right},
               {"missing", Align::right}});
  for (const auto& column : report.columns)
    table.add({column.source, column.unit, column.channel, column.first, significant(column.min, 9),
               significant(column.max, 9),
               column.missing == 0 ? "" : std::to_string(column.missing)});
  table.print(out, paint);
}

void print_first_rows(std::ostream& out, const Dataset& dataset, std::size_t rows) {
  Dataset head = dataset;
  head.rows = std::min(rows, dataset.rows);
  out << formats::write_dataset_csv(head);
}

nlohmann::ordered_json json_from(const formats::ImportReport& report) {
  nlohmann::ordered_json json = {
      {"rows_read", report.rows_read},     {"rows_kept", report.rows_kept},
      {"calibration", report.calibration}, {"validation", report.validation},
      {"late_rows", report.late_rows},     {"spread_rows", report.spread_rows}};
  json["time_zero"] = nullptr;
  if (!report.time_zero.empty()) json["time_zero"] = report.time_zero;
  json["groups"] = {{"count", report.groups},
                    {"smallest", report.smallest_group},
                    {"median", report.median_group},
                    {"largest", report.largest_group}};
  json["dropped"] = nlohmann::ordered_json::array();
  for (const auto& dropped : report.dropped)
    json["dropped"].push_back(
        {{"why", dropped.why}, {"rows", dropped.rows}, {"first_lines", dropped.lines}});
  json["columns"] = nlohmann::ordered_json::array();
  for (const auto& column : report.columns)
    json["columns"].push_back({{"source", column.source},
                               {"unit", column.unit},
                               {"channel", column.channel},
                               {"first", column.first},
                               {"min", number_or_null(column.min)},
                               {"max", number_or_null(column.max)},
                               {"missing", column.missing}});
  json["unused"] = report.unused;
  return json;
}

}  // namespace driftwise::cli
