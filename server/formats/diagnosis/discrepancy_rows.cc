#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "server/core/channel.h"
#include "server/core/reasons.h"
#include "server/formats/diagnosis/stored_diagnosis.h"
#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

using Binary = nlohmann::json;

bool varies(const std::vector<double>& values) {
  double first = kMissing;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    if (std::isfinite(first) && value != first) return true;
    first = value;
  }
  return false;
}

template <class T>
std::vector<double> every(const std::vector<T>& values, std::size_t step) {
  std::vector<double> kept;
  for (std::size_t row = 0; row < values.size(); row += step)
    kept.push_back(static_cast<double>(values[row]));
  return kept;
}

std::vector<double> read_doubles(const Binary& json) { return json.get<std::vector<double>>(); }

tl::unexpected<Error> bad_rows(const std::string& why) {
  return fail(ErrorCode::data_loss, reasons::kBadRows,
              "the stored rows of the diagnosis cannot be read: " + why);
}

// The library reads nested values by calling itself: a few thousand bytes of open brackets would
// run through the stack. Ours are three deep.
class DepthGuard final : public nlohmann::json_sax<Binary> {
 public:
  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(std::int64_t) override { return true; }
  bool number_unsigned(std::uint64_t) override { return true; }
  bool number_float(double, const std::string&) override { return true; }
  bool string(std::string&) override { return true; }
  bool binary(Binary::binary_t&) override { return true; }
  bool key(std::string&) override { return true; }
  bool start_object(std::size_t) override { return ++depth_ <= kDeepest; }
  bool end_object() override { return --depth_ >= 0; }
  bool start_array(std::size_t) override { return ++depth_ <= kDeepest; }
  bool end_array() override { return --depth_ >= 0; }
  bool parse_error(std::size_t, const std::string&, const Binary::exception&) override {
    return false;
  }

 private:
  static constexpr int kDeepest = 16;
  int depth_ = 0;
};

// Whoever plots goes through all of them by the number of rows.
std::optional<std::string> uneven_column(const DiscrepancyRows& rows) {
  const std::size_t count = rows.time_s.size();
  const auto length = [&](const std::string& name,
                          std::size_t found) -> std::optional<std::string> {
    if (found == count) return std::nullopt;
    return name + ": found " + std::to_string(found) + " values, expected " + std::to_string(count);
  };
  if (auto bad = length("validation", rows.validation.size())) return bad;
  if (auto bad = length("line", rows.line.size())) return bad;
  for (const double line : rows.line)
    if (!(std::abs(line) < 1e15)) return "line: found " + number_text(line);
  for (const auto& column : rows.variables)
    if (auto bad = length(column.symbol, column.values.size())) return bad;
  for (const auto& output : rows.outputs) {
    if (auto bad = length(output.output + ", before", output.before.size())) return bad;
    if (auto bad = length(output.output + ", after", output.after.size())) return bad;
  }
  return std::nullopt;
}

}  // namespace

DiscrepancyRows discrepancy_rows(const Dataset& dataset, const diagnosis::Diagnosis& diagnosis,
                                 std::size_t most) {
  const std::size_t step = std::max<std::size_t>(1, (dataset.rows + most - 1) / most);
  DiscrepancyRows rows;
  for (std::size_t row = 0; row < dataset.rows; row += step) {
    rows.time_s.push_back(dataset.time_s.empty() ? static_cast<double>(row) : dataset.time_s[row]);
    rows.validation.push_back(dataset.set_of(row) == PointSet::validation ? 1 : 0);
    rows.line.push_back(dataset.line.empty() ? 0.0 : static_cast<double>(dataset.line[row]));
  }
  for (const auto& column : dataset.columns)
    if (varies(column.values))
      rows.variables.push_back(
          {column.channel.symbol, column.channel.unit, every(column.values, step)});
  if (varies(dataset.dwell_s))
    rows.variables.push_back({"dwell", "s", every(dataset.dwell_s, step)});
  for (const auto& output : diagnosis.outputs)
    rows.outputs.push_back(
        {output.output, output.unit, every(output.before, step), every(output.after, step)});
  return rows;
}

Dataset dataset_of(const DiscrepancyRows& rows, diagnosis::Diagnosis& diagnosis) {
  Dataset dataset;
  dataset.rows = rows.time_s.size();
  dataset.time_s = rows.time_s;
  for (const std::uint8_t validation : rows.validation)
    dataset.set.push_back(validation != 0 ? PointSet::validation : PointSet::calibration);
  for (const double line : rows.line) dataset.line.push_back(static_cast<std::int64_t>(line));
  for (const auto& column : rows.variables) {
    if (column.symbol == "dwell")
      dataset.dwell_s = column.values;
    else
      dataset.columns.push_back({{column.symbol, column.unit}, column.values});
  }
  for (auto& summary : diagnosis.outputs)
    for (const auto& output : rows.outputs)
      if (output.output == summary.output) {
        summary.before = output.before;
        summary.after = output.after;
      }
  return dataset;
}

std::string write_discrepancy_rows(const DiscrepancyRows& rows) {
  Binary json{{"time_s", rows.time_s},
              {"validation", Binary::binary(rows.validation)},
              {"line", rows.line},
              {"variables", Binary::array()},
              {"outputs", Binary::array()}};
  for (const auto& one : rows.variables)
    json["variables"].push_back(
        {{"symbol", one.symbol}, {"unit", one.unit}, {"values", one.values}});
  for (const auto& one : rows.outputs)
    json["outputs"].push_back(
        {{"output", one.output}, {"unit", one.unit}, {"before", one.before}, {"after", one.after}});
  const auto bytes = Binary::to_cbor(json);
  return {bytes.begin(), bytes.end()};
}

Result<DiscrepancyRows> read_discrepancy_rows(std::string_view bytes) {
  DiscrepancyRows rows;
  if (bytes.empty()) return rows;
  DepthGuard guard;
  if (!Binary::sax_parse(bytes.begin(), bytes.end(), &guard, Binary::input_format_t::cbor))
    return bad_rows("they are no CBOR, or too deep");
  try {
    const auto json = Binary::from_cbor(bytes.begin(), bytes.end());
    rows.time_s = read_doubles(json.at("time_s"));
    const auto& sets = json.at("validation").get_binary();
    rows.validation.assign(sets.begin(), sets.end());
    rows.line = read_doubles(json.at("line"));
    for (const auto& one : json.at("variables"))
      rows.variables.push_back({one.at("symbol").get<std::string>(),
                                one.at("unit").get<std::string>(), read_doubles(one.at("values"))});
    for (const auto& one : json.at("outputs"))
      rows.outputs.push_back({one.at("output").get<std::string>(),
                              one.at("unit").get<std::string>(), read_doubles(one.at("before")),
                              read_doubles(one.at("after"))});
  } catch (const nlohmann::json::exception& problem) {
    return bad_rows(problem.what());
  }
  if (const auto uneven = uneven_column(rows)) return bad_rows(*uneven);
  return rows;
}

}  // namespace driftwise::formats
