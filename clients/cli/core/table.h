#pragma once
// A table for people: columns aligned, numbers to the right, units in the header.

#include <ostream>
#include <string>
#include <vector>

#include "clients/cli/core/console.h"

namespace driftwise::cli {

enum class Align { left, right };

class Table {
 public:
  struct Column {
    std::string header;
    Align align = Align::left;
  };
  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  // One text per column; missing ones are empty.
  void add(std::vector<std::string> row);
  bool empty() const { return rows_.empty(); }

  // Two spaces between columns, none at the end of a line; UTF-8 counts by character.
  void print(std::ostream& out, const Paint& paint) const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

// Characters of UTF-8 text, each taken as one cell wide.
std::size_t width_of(const std::string& text);

}  // namespace driftwise::cli
