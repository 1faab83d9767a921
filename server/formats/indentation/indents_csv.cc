#include "server/formats/indentation/indents_csv.h"

#include <algorithm>
#include <functional>
#include <map>

#include "server/core/data/reading.h"
#include "server/core/reasons.h"
#include "server/core/text/shown_text.h"
#include "server/core/try.h"
#include "server/formats/csv/csv_text.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

constexpr const char* kDiagonal = "diagonal_um";

// Reads one field of a row into its place; false: rows.error() says why.
template <class Row>
using Columns = std::map<std::string, std::function<bool(CsvRows&, Row&)>>;

template <class Row>
auto number(double Row::*place) {
  return [place](CsvRows& rows, Row& row) { return rows.number(row.*place); };
}

template <class Row>
auto count(int Row::*place) {
  return [place](CsvRows& rows, Row& row) {
    std::int64_t value = 0;
    if (!rows.integer(value)) return false;
    row.*place = static_cast<int>(std::clamp<std::int64_t>(value, -1, 1'000'000));
    return true;
  };
}

// check: of a whole row, its complaint or nothing.
template <class Row>
Result<std::vector<Row>> read(std::string_view text, const std::string& file_name,
                              const Columns<Row>& columns,
                              const std::function<std::string(const Row&)>& complaint) {
  DRIFTWISE_TRY(const auto header, read_csv_header(text, file_name));
  std::string wanted;
  for (const auto& [name, unused] : columns) {
    wanted += (wanted.empty() ? "" : ", ") + name;
    if (name != kDiagonal && std::ranges::find(header.names, name) == header.names.end())
      return fail(ErrorCode::invalid_argument, reasons::kNoColumn,
                  at_line(file_name, header.line) + "there is no column " + name +
                      "; a table of indents has " + wanted);
  }
  for (const auto& name : header.names)
    if (!columns.contains(name))
      return fail(ErrorCode::invalid_argument, reasons::kUnknownColumn,
                  at_line(file_name, header.line) + "column " + shown(name) +
                      " is not known, expected " + wanted);
  std::vector<Row> found;
  for (const auto& chunk : chunks_of(header)) {
    CsvRows rows(header, file_name, chunk);
    while (rows.next_row()) {
      Row row;
      for (const auto& name : header.names)
        if (!columns.at(name)(rows, row)) return tl::unexpected(rows.error());
      if (const std::string what = complaint(row); !what.empty())
        return fail(ErrorCode::invalid_argument, reasons::kBadValue,
                    at_line(file_name, rows.line()) + what);
      found.push_back(std::move(row));
    }
    if (rows.failed()) return tl::unexpected(rows.error());
  }
  if (found.empty())
    return fail(ErrorCode::invalid_argument, reasons::kNoRows,
                file_name + ": there is no row below the header");
  return found;
}

}  // namespace

Result<std::vector<indentation::Indent>> read_indents_csv(std::string_view text,
                                                          const std::string& file_name) {
  using indentation::Indent;
  struct Read : Indent {
    std::string line_text;
  };
  const auto in = [](double Indent::*place) {
    return [place](CsvRows& rows, Read& row) { return rows.number(row.*place); };
  };
  const Columns<Read> columns{
      {"id", [](CsvRows& rows, Read& row) { return rows.text(row.id); }},
      {"line", [](CsvRows& rows, Read& row) { return rows.text(row.line_text); }},
      {"wanted_um", in(&Indent::wanted_um)},
      {"rx_arcsec", in(&Indent::rx_arcsec)},
      {"ry_arcsec", in(&Indent::ry_arcsec)},
      {"measured_um", in(&Indent::measured_um)},
      {"pixel_nm", in(&Indent::pixel_nm)},
      {"marking_px", in(&Indent::marking_px)},
      {"pictures_joined",
       [](CsvRows& rows, Read& row) {
         std::int64_t value = 0;
         if (!rows.integer(value)) return false;
         row.pictures_joined = static_cast<int>(std::clamp<std::int64_t>(value, -1, 1'000'000));
         return true;
       }},
      {kDiagonal, in(&Indent::diagonal_um)}};
  DRIFTWISE_TRY(const auto read_rows,
                read<Read>(text, file_name, columns, [](const Read& row) -> std::string {
                  if (row.line_text == "x" || row.line_text == "y") return "";
                  return "column line: found " + shown(row.line_text) + ", expected x or y";
                }));
  std::vector<Indent> indents;
  for (const auto& row : read_rows) {
    indents.push_back(row);
    indents.back().line = row.line_text == "x" ? indentation::Line::x : indentation::Line::y;
    if (is_missing(row.diagonal_um)) indents.back().diagonal_um = 0;
  }
  return indents;
}

std::string write_indents_csv(const std::vector<indentation::Indent>& indents) {
  std::string text =
      "id,line,wanted_um,rx_arcsec,ry_arcsec,measured_um,pixel_nm,marking_px,pictures_joined,"
      "diagonal_um\n";
  for (const auto& one : indents) {
    text += one.id + (one.line == indentation::Line::x ? ",x" : ",y");
    for (const double value : {one.wanted_um, one.rx_arcsec, one.ry_arcsec, one.measured_um,
                               one.pixel_nm, one.marking_px})
      text += "," + number_text(value);
    text += "," + std::to_string(one.pictures_joined) + "," + number_text(one.diagonal_um) + "\n";
  }
  return text;
}

Result<std::vector<MicroscopeIndent>> read_microscope_csv(std::string_view text,
                                                          const std::string& file_name) {
  using Row = MicroscopeIndent;
  const Columns<Row> columns{{"id", count(&Row::id)},
                             {"x_um", number(&Row::x_um)},
                             {"y_um", number(&Row::y_um)},
                             {"pixel_nm", number(&Row::pixel_nm)},
                             {"marking_px", number(&Row::marking_px)},
                             {"pictures_joined", count(&Row::pictures_joined)},
                             {kDiagonal, number(&Row::diagonal_um)}};
  return read<Row>(text, file_name, columns, [](const Row& row) -> std::string {
    if (is_missing(row.x_um) || is_missing(row.y_um)) return "x_um or y_um is empty";
    return row.id >= 1 ? "" : "column id: expected the number of a contact, from 1";
  });
}

}  // namespace driftwise::formats
