// Reading a dataset CSV: in chunks of whole lines, each straight into its place in the columns.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>

#include "server/core/data/row_marks.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/formats/csv/csv_text.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/csv/metadata_check.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

enum class CsvColumn : std::uint8_t {
  time,
  set,
  line,
  zero,
  dwell,
  run,
  datum,
  excluded,
  suspect,
  passage,
  channel
};

struct Named {
  std::string_view name;
  CsvColumn kind;
};
constexpr std::array<Named, 10> kOwnColumns = {{{"time_s", CsvColumn::time},
                                                {"set", CsvColumn::set},
                                                {"line", CsvColumn::line},
                                                {"zero", CsvColumn::zero},
                                                {"dwell_s", CsvColumn::dwell},
                                                {"run", CsvColumn::run},
                                                {"datum", CsvColumn::datum},
                                                {"excluded", CsvColumn::excluded},
                                                {"suspect", CsvColumn::suspect},
                                                {"passage", CsvColumn::passage}}};

// With the columns that end up as marks in excluded.
struct DatasetRead : Dataset {
  std::vector<std::uint8_t> suspect, passage;
};

void take_over(const std::vector<std::uint8_t>& column, std::uint8_t mark, Dataset& data) {
  if (column.empty()) return;
  if (data.excluded.empty()) data.excluded.assign(data.rows, kInUse);
  for (std::size_t row = 0; row < data.rows; ++row)
    if (column[row] != 0) data.excluded[row] = mark;
}

// A column of the file, and where its values go.
struct Column {
  CsvColumn kind = CsvColumn::channel;
  double* numbers = nullptr;
  std::int64_t* integers = nullptr;
  std::uint8_t* flags = nullptr;
  PointSet* sets = nullptr;
};

Result<void> check_version(const CsvHeader& header, const std::string& file_name) {
  for (const auto& [key, value] : header.metadata)
    if (key == kDatasetVersionKey && value != "1")
      return fail(ErrorCode::invalid_argument, reasons::kUnsupportedVersion,
                  at_line(file_name, 1) + "found driftwise-dataset " + shown(value) +
                      ", expected version 1");
  return {};
}

// Refusal of another program's header, with the command that makes a dataset of the file.
Error with_way_out(Error error) {
  if (error.reason == reasons::kNoHeader || error.reason == reasons::kQuotedField ||
      error.reason == reasons::kBadChannel)
    error.message +=
        "; another program's table: driftwise data import FILE --mapping MAP.toml -o dataset.csv "
        "(docs/import.md)";
  return error;
}

// Fills data.columns and says for each column of the file what it is.
Result<std::vector<CsvColumn>> sort_columns(const CsvHeader& header, const std::string& file_name,
                                            DatasetRead& data) {
  std::vector<CsvColumn> kinds(header.names.size(), CsvColumn::channel);
  std::unordered_map<std::string, std::size_t> places;  // by symbol, into data.columns
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const auto& name = header.names[i];
    for (const auto& own : kOwnColumns)
      if (name == own.name) kinds[i] = own.kind;
    if (kinds[i] != CsvColumn::channel) continue;
    auto channel = parse_robot_channel(name);
    if (!channel) {
      std::string message = at_line(file_name, header.line) + "column " + std::to_string(i + 1) +
                            ": " + channel.error().message;
      if (name.starts_with("time") || name.starts_with("Time"))
        message += "; the time of a row goes in time_s, in seconds";
      return fail(ErrorCode::invalid_argument, channel.error().reason, std::move(message));
    }
    const auto [place, is_new] = places.emplace(channel->symbol, data.columns.size());
    if (!is_new) {
      const Channel& other = data.columns[place->second].channel;
      return fail(ErrorCode::invalid_argument, reasons::kUnitsDisagree,
                  at_line(file_name, header.line) + "column " + std::to_string(i + 1) + ": " +
                      name + " gives " + channel->symbol + " in " + channel->unit + ", and " +
                      other.name() + " gives it in " + other.unit +
                      " already; expected each quantity once, in one unit");
    }
    data.columns.push_back({std::move(*channel), {}});
  }
  return kinds;
}

// Calls use(vector) for the vector of every column of the file, the channels in their order.
template <class Use>
void visit_column(DatasetRead& data, CsvColumn kind, std::size_t channel, Use use) {
  switch (kind) {
    case CsvColumn::time:
      return use(data.time_s);
    case CsvColumn::set:
      return use(data.set);
    case CsvColumn::line:
      return use(data.line);
    case CsvColumn::zero:
      return use(data.zero);
    case CsvColumn::dwell:
      return use(data.dwell_s);
    case CsvColumn::run:
      return use(data.run);
    case CsvColumn::datum:
      return use(data.datum);
    case CsvColumn::excluded:
      return use(data.excluded);
    case CsvColumn::suspect:
      return use(data.suspect);
    case CsvColumn::passage:
      return use(data.passage);
    case CsvColumn::channel:
      return use(data.columns[channel].values);
  }
}

// Number of channels before each column of the file.
std::vector<std::size_t> channels_before(const std::vector<CsvColumn>& kinds) {
  std::vector<std::size_t> before(kinds.size());
  for (std::size_t i = 1; i < kinds.size(); ++i)
    before[i] = before[i - 1] + (kinds[i - 1] == CsvColumn::channel ? 1 : 0);
  return before;
}

void set_place(Column& column, std::vector<double>& values) { column.numbers = values.data(); }
void set_place(Column& column, std::vector<std::int64_t>& values) {
  column.integers = values.data();
}
void set_place(Column& column, std::vector<std::uint8_t>& values) { column.flags = values.data(); }
void set_place(Column& column, std::vector<PointSet>& values) { column.sets = values.data(); }

// Room for so many rows in every column; the first touch of that much memory is worth sharing out.
std::vector<Column> make_room(DatasetRead& data, const std::vector<CsvColumn>& kinds,
                              std::size_t rows, const calibration::Executor& executor) {
  const auto before = channels_before(kinds);
  std::vector<Column> columns(kinds.size());
  calibration::run_on(executor, kinds.size(), [&](std::size_t i) {
    columns[i].kind = kinds[i];
    visit_column(data, kinds[i], before[i], [&](auto& values) {
      values.resize(rows);
      set_place(columns[i], values);
    });
  });
  return columns;
}

bool read_row(CsvRows& rows, const std::vector<Column>& columns, std::size_t at) {
  for (const auto& column : columns) {
    bool truth = false;
    switch (column.kind) {
      case CsvColumn::time:
      case CsvColumn::dwell:
      case CsvColumn::channel:
        if (!rows.number(column.numbers[at])) return false;
        break;
      case CsvColumn::set:
        if (!rows.set_is_validation(truth)) return false;
        column.sets[at] = truth ? PointSet::validation : PointSet::calibration;
        break;
      case CsvColumn::zero:
      case CsvColumn::excluded:
      case CsvColumn::suspect:
      case CsvColumn::passage:
        if (!rows.flag(truth)) return false;
        column.flags[at] = truth ? 1 : 0;
        break;
      case CsvColumn::line:
      case CsvColumn::run:
      case CsvColumn::datum:
        if (!rows.integer(column.integers[at])) return false;
        break;
    }
  }
  return true;
}

struct Found {  // in one chunk
  std::size_t rows = 0;
  std::size_t first_line = 0;  // of its first row
  std::optional<Error> error;  // in the row after those
};

class Reader {
 public:
  Reader(const CsvHeader& header, const std::string& file_name, const std::vector<Column>& columns)
      : header_(header), file_name_(file_name), columns_(columns) {
    while (time_ < columns.size() && columns[time_].kind != CsvColumn::time) ++time_;
    while (run_ < columns.size() && columns[run_].kind != CsvColumn::run) ++run_;
  }

  Found read(const CsvChunk& chunk) const {
    Found found;
    CsvRows rows(header_, file_name_, chunk);
    while (rows.next_row()) {
      const std::size_t at = chunk.first_row + found.rows;
      if (!read_row(rows, columns_, at)) break;
      if (timed() && is_missing(time(at)))
        found.error = rows.problem(reasons::kBadNumber, time_, "found nothing, expected seconds");
      else if (timed() && found.rows > 0)
        found.error = out_of_order(rows, at - 1, at);
      if (found.error) return found;
      if (found.rows++ == 0) found.first_line = rows.line();
    }
    if (rows.failed()) found.error = with_way_to_time(rows.error());
    return found;
  }

  // Of a chunk's first row against the last one before it.
  std::optional<Error> out_of_order(const CsvChunk& chunk, const Found& found,
                                    std::size_t last) const {
    if (!timed()) return std::nullopt;
    const CsvRows at_first(header_, file_name_, {{}, found.first_line, 0, 0});
    return out_of_order(at_first, last, chunk.first_row);
  }

 private:
  bool timed() const { return time_ < columns_.size(); }
  double time(std::size_t row) const { return columns_[time_].numbers[row]; }
  std::optional<Error> out_of_order(const CsvRows& rows, std::size_t before,
                                    std::size_t now) const {
    if (time(now) > time(before)) return std::nullopt;
    return rows.problem(reasons::kTimeNotIncreasing, time_,
                        "found " + number_text(time(now)) + " after " + number_text(time(before)) +
                            ", expected a later time in every row: " + mended(before, now));
  }

  // Advice on a time that does not increase. Sorting is wrong where a run was put behind
  // another one: it would mix their rows.
  std::string mended(std::size_t before, std::size_t now) const {
    constexpr const char* kUntimed = "leave the column out, and the rows count in their order";
    if (time(now) == time(before))
      return std::string("leave out a row that is there twice; where the clock is too coarse, ") +
             kUntimed;
    const std::string later = "add " + number_text(std::ceil(time(before) - time(now))) +
                              " s, and the pause between the runs, to the times from this line on";
    if (run_ < columns_.size() && columns_[run_].integers[now] != columns_[run_].integers[before])
      return "the clock restarts with run " + std::to_string(columns_[run_].integers[now]) + ": " +
             later;
    return "where a second run begins here and its clock restarts, " + later +
           ", and number the runs in a column run; where single rows are out of order, sort them; "
           "else " +
           kUntimed;
  }

  // A date and time of day in time_s: what reads it.
  Error with_way_to_time(Error error) const {
    if (timed() && error.reason == reasons::kBadNumber &&
        error.message.find("column time_s: found '") != std::string::npos)
      error.message +=
          "; time_s is in seconds from any start; dates and times of day: driftwise data import "
          "FILE --mapping MAP.toml -o dataset.csv (docs/import.md)";
    return error;
  }

  const CsvHeader& header_;
  const std::string& file_name_;
  const std::vector<Column>& columns_;
  std::size_t time_ = 0, run_ = 0;  // columns; number of columns: none
};

// The first error in the order of the rows, whoever met it first.
std::optional<Error> first_error(const Reader& reader, const std::vector<CsvChunk>& chunks,
                                 const std::vector<Found>& found) {
  std::optional<std::size_t> last;
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    if (found[i].rows > 0 && last)
      if (auto error = reader.out_of_order(chunks[i], found[i], *last)) return error;
    if (found[i].error) return found[i].error;
    if (found[i].rows > 0) last = chunks[i].first_row + found[i].rows - 1;
  }
  return std::nullopt;
}

// Rows move up where lines were empty.
template <class Value>
void close_gaps(std::vector<Value>& values, const std::vector<CsvChunk>& chunks,
                const std::vector<Found>& found) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    const auto from = values.begin() + static_cast<std::ptrdiff_t>(chunks[i].first_row);
    if (next != chunks[i].first_row)
      std::copy(from, from + static_cast<std::ptrdiff_t>(found[i].rows),
                values.begin() + static_cast<std::ptrdiff_t>(next));
    next += found[i].rows;
  }
  values.resize(next);
}

}  // namespace

Result<Dataset> read_dataset_csv(std::string_view text, const std::string& file_name,
                                 const calibration::Executor& executor, const CsvLimits& limits) {
  DRIFTWISE_TRY(const auto header,
                read_csv_header(text, file_name, limits).map_error(with_way_out));
  DRIFTWISE_RETURN_IF_ERROR(check_version(header, file_name));
  DatasetRead data;
  data.metadata = header.metadata;
  DRIFTWISE_TRY(const auto kinds, sort_columns(header, file_name, data).map_error(with_way_out));

  DRIFTWISE_RETURN_IF_ERROR(check_metadata(text, data, file_name));
  const auto chunks = chunks_of(header, executor);
  const std::size_t most_rows = chunks.back().first_row + chunks.back().most_rows;
  if (most_rows > limits.values / header.names.size())
    return fail(ErrorCode::invalid_argument, reasons::kTooManyValues,
                at_line(file_name, header.line) + "found up to " + std::to_string(most_rows) +
                    " rows of " + std::to_string(header.names.size()) +
                    " columns, expected at most " + std::to_string(limits.values) +
                    " values in all: split the file, or work on it with the command line");
  const auto columns = make_room(data, kinds, most_rows, executor);
  const Reader reader(header, file_name, columns);
  std::vector<Found> found(chunks.size());
  calibration::run_on(executor, chunks.size(),
                      [&](std::size_t i) { found[i] = reader.read(chunks[i]); });
  if (const auto error = first_error(reader, chunks, found)) return tl::unexpected(*error);
  for (const auto& chunk : found) data.rows += chunk.rows;
  if (data.rows == 0)
    return fail(ErrorCode::invalid_argument, reasons::kNoRows,
                at_line(file_name, header.line) +
                    "found a header row and nothing after it, expected one row per point");
  const auto before = channels_before(kinds);
  for (std::size_t i = 0; i < kinds.size(); ++i)
    visit_column(data, kinds[i], before[i],
                 [&](auto& values) { close_gaps(values, chunks, found); });
  take_over(data.suspect, kSuspectRow, data);
  take_over(data.passage, kPassageRow, data);
  return std::move(static_cast<Dataset&>(data));
}

}  // namespace driftwise::formats
