#pragma once
// One row of a foreign table -> numbers, by the mapping's column rules.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/reasons.h"
#include "server/formats/import/foreign_rows.h"
#include "server/formats/import/source_table.h"

namespace driftwise::formats {

class RowReader {
 public:
  // Errors: those of SourceTable::find. All three outlive the reader.
  static Result<RowReader> make(const ImportMapping& mapping, const SourceTable& table,
                                const std::string& file_name);

  // The first drop rule that holds for this row; fields are as many as the table's columns.
  // Errors: BAD_NUMBER of a field that below or above cannot be held against.
  Result<std::optional<std::size_t>> dropped_by(const ForeignRows& row) const;
  // One number per column rule, in order, converted; kMissing where nothing stands.
  // Errors: BAD_NUMBER, BAD_INTEGER, BAD_FLAG, MISSING_VALUE.
  Result<void> read(const ForeignRows& row, std::vector<double>& values) const;
  // Errors: BAD_TIME. Only with a [time] table.
  struct Stamp {
    CellTime time;
    bool local;  // it says no zone
  };
  Result<Stamp> time(const ForeignRows& row) const;
  // Errors: MISSING_VALUE. Only with sets by a column.
  Result<bool> is_validation(const ForeignRows& row) const;

  std::size_t field_of(std::size_t column_rule) const { return columns_[column_rule]; }
  // Fields that some rule reads.
  std::vector<bool> used() const;
  Error problem(const ForeignRows& row, std::size_t field, Reason reason,
                const std::string& sentence) const;

 private:
  RowReader(const ImportMapping& mapping, const SourceTable& table, const std::string& file_name)
      : mapping_(&mapping), table_(&table), file_name_(&file_name) {}
  bool is_missing_text(const std::string& text) const;
  Result<double> number(const ForeignRows& row, std::size_t field, int shift = 0) const;
  Result<double> value(const ForeignRows& row, std::size_t rule) const;

  const ImportMapping* mapping_;
  const SourceTable* table_;
  const std::string* file_name_;
  std::vector<std::size_t> columns_, drops_, times_;  // fields, in the rules' order
  std::vector<std::optional<int>> shifts_;  // of the columns whose conversion moves the point only
  std::size_t set_ = 0;
};

}  // namespace driftwise::formats
