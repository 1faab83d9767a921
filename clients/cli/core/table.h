#pragma once
// A table for people: columns aligned, numbers to the right, units in the header.

#include <ostream>
#include <string>
#include <vector>

#include "clients/cli/core/console.h"

namespace driftwise::cli {

enum class Align { left, right };

enum class Colour { none, good, warn, bad, dim };

class Table {
 public:
  // One cell: what it says, and its colour where there are colours. Apart, because the text is
  // cleaned of what a terminal would obey.
  struct Cell {
    Cell(std::string shown, Colour in = Colour::none) : text(std::move(shown)), colour(in) {}
    Cell(const char* shown, Colour in = Colour::none) : text(shown), colour(in) {}
    std::string text;
    Colour colour;
  };
  struct Column {
    std::string header;
    Align align = Align::left;
  };
  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  // One cell per column; missing ones are empty.
  void add(std::vector<Cell> row);
  bool empty() const { return rows_.empty(); }

  // Two spaces between columns, none at the end of a line; UTF-8 counts by character.
  void print(std::ostream& out, const Paint& paint) const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<Cell>> rows_;
};

// Characters of UTF-8 text, each taken as one cell wide.
std::size_t width_of(const std::string& text);

}  // namespace driftwise::cli
