#pragma once
// What the demos' tables share: files, figures of a fit's JSON, spreads, the plant's private log.

#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "server/core/data/accuracy.h"
#include "server/core/data/dataset.h"

namespace driftwise::demo {

std::string read_file(const std::string& path);  // throws std::runtime_error
nlohmann::json read_json(const std::string& path);
// Without its passages: a report counts points.
Dataset read_dataset(const std::string& path);

// A number of a JSON object; NaN where there is none.
double figure(const nlohmann::json& object, const char* key);
int terms_in(const nlohmann::json& output);

std::string text(const ErrorFigures& figures);  // A90 (mean, U90): "41.2 (+3.0, 40.8)"

// What `driftwise run verify N --json` printed of a coordinate: of all its points, and without what
// the axes missed of their own targets (nothing: not known). Target minus measured, nm.
struct ByInstrument {
  ErrorFigures all;
  std::optional<ErrorFigures> by_model;
};
ByInstrument by_instrument(const nlohmann::json& verification, const std::string& coordinate);

// "# time_zero:" of an exported run: what its time_s counts from, UTC.
std::int64_t time_zero_ns(const Dataset& data, const std::string& path);

// Half of the shortest time between two rows: what is nearer to a row belongs to it. 0: one row.
std::int64_t half_of_shortest_step_ns(const Dataset& data);

// truth.csv: where the end-effector really was, a row for every zeroing and every length read.
class TruthTable {
 public:
  explicit TruthTable(const std::string& path);
  // One column (nm) when the lengths were last zeroed up to an instant; NaN before the first.
  double at_zero(const std::string& column, std::int64_t until_ns) const;
  // Its mean over the rows of lengths within 3 s of an instant: those of one point's readings. A
  // busy computer stamps them later than the plant answered: then those about the nearest row, at
  // most late_ns away. Throws std::runtime_error where there is none.
  double mean_about(const std::string& column, std::int64_t middle_ns, std::int64_t late_ns) const;
  // Its mean over the rows of any kind within 30 s of an instant in which q1, q2 and q3 rest where
  // they were commanded. Holds also where a busy computer answers seconds of cell time late.
  double mean_at_rest(const std::string& column, std::int64_t middle_ns,
                      const std::array<double, 3>& commanded_mm) const;

 private:
  std::map<std::string, std::size_t> columns_;
  struct Row {
    std::int64_t time_ns = 0;
    bool zero = false, length = false;
    std::vector<double> values;
  };
  std::vector<Row> rows_;  // in time order
  std::size_t column(const std::string& name) const;
};

// Throws std::runtime_error where there is none.
const DatasetColumn& need_column(const Dataset& data, const std::string& symbol);
bool is_zero_row(const Dataset& data, std::size_t row);
std::array<double, 3> commanded_mm(const Dataset& data, std::size_t row);

// The truth of the rows of one run, counted from its first return to zero.
class TruthOfRun {
 public:
  TruthOfRun(const Dataset& data, const std::string& path, const TruthTable& truth)
      : data_(data), truth_(truth), zero_ns_(time_zero_ns(data, path)) {
    while (first_zero_ < data.rows && !is_zero_row(data, first_zero_)) ++first_zero_;
    if (first_zero_ == data.rows) throw std::runtime_error(path + ": no return to zero");
  }
  double at(const std::string& column, std::size_t row) const {
    return mean(column, row) - mean(column, first_zero_);
  }

 private:
  double mean(const std::string& column, std::size_t row) const {
    return truth_.mean_at_rest(column,
                               zero_ns_ + static_cast<std::int64_t>(data_.time_s[row] * 1e9),
                               commanded_mm(data_, row));
  }
  const Dataset& data_;
  const TruthTable& truth_;
  std::int64_t zero_ns_;
  std::size_t first_zero_ = 0;
};

}  // namespace driftwise::demo
