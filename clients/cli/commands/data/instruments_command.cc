#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "clients/cli/commands/data/exported_csv.h"
#include "clients/cli/commands/data/join_command.h"
#include "clients/cli/core/input_text.h"
#include "clients/cli/core/proto_json.h"
#include "clients/cli/core/table.h"
#include "clients/cli/core/text.h"
#include "clients/cli/core/value_or_throw.h"
#include "driftwise/v1/data_service.grpc.pb.h"
#include "driftwise/v1/run_service.grpc.pb.h"
#include "server/core/data/row_marks.h"
#include "server/core/reasons.h"
#include "server/core/units.h"
#include "server/correction/instrument_match.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/csv/trajectory_rows.h"

namespace driftwise::cli {
namespace {

struct InstrumentArguments {
  std::string reference, table;
  std::vector<std::string> axes;  // "x=gauge_x"
  bool no_scale = false, no_rotation = false;
  std::size_t most_rows = 10;
};

// Channels by trajectory row, of one side, without the rows that are kept out.
struct NamedColumns {
  std::string name;
  std::vector<std::int64_t> row;
  std::map<std::string, std::vector<double>> mm;  // by symbol; lengths alone
};

Failure bad_table(const std::string& message) {
  return Failure{ExitCode::bad_input, "invalid_argument", reasons::kUnknownChannel, message};
}

// name: the file, or "run 3" of an imported one.
NamedColumns columns_of_text(std::string_view text, const std::string& name, bool needs_row) {
  auto data = value_or_throw(formats::read_dataset_csv(text, name));
  leave_passages_out(data);  // they are none of the trajectory
  NamedColumns out{.name = name, .row = {}, .mm = {}};
  const auto* row = data.find("row");
  if (!row && needs_row)
    throw bad_table(name +
                    ": no column row_1: each line of the table names the row of the trajectory "
                    "that it belongs to, counted from 1");
  std::vector<std::int64_t> counted;
  if (!row) counted = value_or_throw(formats::trajectory_rows(data, name));
  for (std::size_t k = 0; k < data.rows; ++k) {
    const double number = row ? row->values[k] : static_cast<double>(counted[k]);
    if (!(number >= 1) || number != std::floor(number) || number > 1e9)
      throw Failure{ExitCode::bad_input, "invalid_argument", reasons::kBadInteger,
                    name + ": row_1 of data row " + std::to_string(k + 1) +
                        ": expected the number of a row of the trajectory, from 1"};
    if (data.is_excluded(k)) continue;
    out.row.push_back(static_cast<std::int64_t>(number));
  }
  for (const auto& column : data.columns) {
    if (!is_length(column.channel.unit)) continue;
    auto& values = out.mm[column.channel.symbol];
    const double factor = mm_from_nm(summary_unit(column.channel.unit).factor);
    for (std::size_t k = 0; k < data.rows; ++k)
      if (!data.is_excluded(k)) values.push_back(column.values[k] * factor);
  }
  return out;
}

NamedColumns columns_of_file(const std::string& file, bool needs_row) {
  const InputText input(file);
  return columns_of_text(input.text(), file, needs_row);
}

std::vector<v1::RowRange> rows_kept_out(const Connection& connection, std::int64_t run) {
  v1::ListExclusionsRequest request;
  request.set_run_id(run);
  const auto response = connection.ask(&v1::DataService::Stub::ListExclusions, request);
  return {response.state().excluded_rows().begin(), response.state().excluded_rows().end()};
}

NamedColumns columns_of_run(const Session& session, std::int64_t run) {
  constexpr int kPage = 10'000;
  NamedColumns out{.name = "run " + std::to_string(run), .row = {}, .mm = {}};
  const auto connection = session.connect();
  v1::GetRunRequest which;
  which.set_run_id(run);
  // Of an imported run the rows are those of its file, numbered as there.
  if (connection.ask(&v1::RunService::Stub::GetRun, which).run().reason() == "imported")
    return columns_of_text(exported_csv(session, {run}, false), out.name, false);
  const auto kept_out = rows_kept_out(connection, run);
  for (std::int64_t after = 0;;) {
    v1::ListPointsRequest request;
    request.set_run_id(run);
    request.set_after_point_id(after);
    request.set_limit(kPage);
    const auto page = connection.ask(&v1::RunService::Stub::ListPoints, request);
    for (const auto& point : page.points()) {
      after = point.id();
      if (point.repeated_line() || point.passage()) continue;
      if (std::ranges::any_of(kept_out, [&point](const v1::RowRange& range) {
            return point.row() >= range.first_row() && point.row() <= range.last_row();
          }))
        continue;
      for (const auto& value : point.values()) {
        const auto channel = parse_robot_channel(value.channel());
        if (!channel || !is_length(channel->unit)) continue;
        auto& values = out.mm[channel->symbol];
        values.resize(out.row.size(), kMissing);
        values.push_back(value.has_value()
                             ? value.value() * mm_from_nm(summary_unit(channel->unit).factor)
                             : kMissing);
      }
      out.row.push_back(point.row());
    }
    if (page.points_size() < kPage) break;
  }
  for (auto& [symbol, values] : out.mm) values.resize(out.row.size(), kMissing);
  return out;
}

struct AxisPair {
  std::string reference, other;
};

// Those of --axis; else x, y, z as far as both have them.
std::vector<AxisPair> pairs_of(const std::vector<std::string>& texts, const NamedColumns& reference,
                               const NamedColumns& other) {
  std::vector<AxisPair> pairs;
  for (const auto& text : texts) {
    const auto equals = text.find('=');
    AxisPair pair{text.substr(0, equals),
                  equals == std::string::npos ? text : text.substr(equals + 1)};
    for (const auto& [columns, symbol] :
         {std::pair{&reference, pair.reference}, std::pair{&other, pair.other}})
      if (!columns->mm.contains(symbol))
        throw bad_table(columns->name + ": no length '" + symbol + "'");
    pairs.push_back(std::move(pair));
  }
  if (texts.empty())
    for (const char* axis : {"x", "y", "z"})
      if (reference.mm.contains(axis) && other.mm.contains(axis)) pairs.push_back({axis, axis});
  if (pairs.empty() || pairs.size() > 3)
    throw bad_table(reference.name + " and " + other.name + " share " +
                    std::to_string(pairs.size()) +
                    " of x, y, z, expected one to three; --axis x=gauge_x names them");
  return pairs;
}

// Rows in which nothing is missing.
correction::InstrumentRows rows_of(const NamedColumns& columns,
                                   const std::vector<std::string>& symbols) {
  std::vector<std::size_t> whole;
  for (std::size_t k = 0; k < columns.row.size(); ++k)
    if (std::ranges::none_of(symbols, [&](const std::string& symbol) {
          return is_missing(columns.mm.at(symbol)[k]);
        }))
      whole.push_back(k);
  correction::InstrumentRows out;
  out.name = columns.name;
  out.mm.resize(static_cast<Eigen::Index>(symbols.size()), static_cast<Eigen::Index>(whole.size()));
  const auto u = columns.mm.find("u");
  if (u != columns.mm.end()) out.u_mm.resize(static_cast<Eigen::Index>(whole.size()));
  for (std::size_t i = 0; i < whole.size(); ++i) {
    out.row.push_back(columns.row[whole[i]]);
    for (std::size_t axis = 0; axis < symbols.size(); ++axis)
      out.mm(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(i)) =
          columns.mm.at(symbols[axis])[whole[i]];
    if (u != columns.mm.end()) out.u_mm[static_cast<Eigen::Index>(i)] = u->second[whole[i]];
  }
  return out;
}

std::vector<std::string> turn_names(const correction::InstrumentMatch& match) {
  if (match.rotation_arcsec.size() == 3) return {"rx", "ry", "rz"};
  if (match.rotation_arcsec.size() == 1) return {match.axes[0] + " to " + match.axes[1]};
  return {};
}

// Rows by their largest residual.
std::vector<Eigen::Index> worst_rows(const correction::InstrumentMatch& match, std::size_t most) {
  std::vector<Eigen::Index> order(match.row.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<Eigen::Index>(k);
  std::ranges::stable_sort(order, std::greater<>(),
                           [&](Eigen::Index k) { return match.residual_nm.col(k).norm(); });
  order.resize(std::min(order.size(), most));
  return order;
}

nlohmann::ordered_json match_json(const correction::InstrumentMatch& match) {
  using Json = nlohmann::ordered_json;
  const auto list = [](const auto& vector) {
    return std::vector<double>(vector.begin(), vector.end());
  };
  Json json{{"schema", "driftwise.instruments.v1"},
            {"axes", match.axes},
            {"rows", match.row.size()},
            {"reference_only", match.reference_only},
            {"table_only", match.other_only},
            {"scale_ppm", match.scale_ppm}};
  json["u_scale_ppm"] = match.u_scale_ppm ? Json(*match.u_scale_ppm) : Json(nullptr);
  json["offset_nm"] = list(match.offset_nm);
  json["u_offset_nm"] = list(match.u_offset_nm);
  json["rotation_arcsec"] = list(match.rotation_arcsec);
  json["u_rotation_arcsec"] = list(match.u_rotation_arcsec);
  json["rms_nm"] = list(match.rms_nm);
  json["birge"] = match.birge ? Json(*match.birge) : Json(nullptr);
  json["findings"] = match.findings;
  json["residuals"] = Json::array();
  for (std::size_t k = 0; k < match.row.size(); ++k)
    json["residuals"].push_back(
        {{"row", match.row[k]}, {"nm", list(match.residual_nm.col(static_cast<Eigen::Index>(k)))}});
  return json;
}

void print_match(const Console& console, const correction::InstrumentMatch& match,
                 std::size_t most_rows) {
  console.out << match.row.size() << " rows in both";
  if (match.reference_only + match.other_only > 0)
    console.out << ", " << match.reference_only << " of the first and " << match.other_only
                << " of the table are in one only";
  console.out << "\n\n";
  Table figures(
      {{"of the table against the first"}, {"", Align::right}, {"u", Align::right}, {""}});
  figures.add({"scale", signed_fixed(match.scale_ppm, 3),
               match.u_scale_ppm ? fixed(*match.u_scale_ppm, 3) : "held", "ppm"});
  for (Eigen::Index k = 0; k < match.offset_nm.size(); ++k)
    figures.add({"offset " + match.axes[static_cast<std::size_t>(k)],
                 signed_fixed(match.offset_nm[k], 1), fixed(match.u_offset_nm[k], 1), "nm"});
  const auto turns = turn_names(match);
  for (std::size_t k = 0; k < turns.size(); ++k)
    figures.add({"rotation " + turns[k],
                 signed_fixed(match.rotation_arcsec[static_cast<Eigen::Index>(k)], 3),
                 fixed(match.u_rotation_arcsec[static_cast<Eigen::Index>(k)], 3), "arcsec"});
  for (Eigen::Index k = 0; k < match.rms_nm.size(); ++k)
    figures.add({"left in " + match.axes[static_cast<std::size_t>(k)] + ", rms",
                 fixed(match.rms_nm[k], 1), "", "nm"});
  if (match.birge) figures.add({"left, times the stated u", fixed(*match.birge, 2), "", ""});
  figures.print(console.out, console.paint_out());
  for (const auto& finding : match.findings) console.out << '\n' << finding << '\n';
  std::vector<Table::Column> columns = {{"row", Align::right}};
  for (const auto& axis : match.axes) columns.push_back({axis + ", nm", Align::right});
  Table rows(columns);
  for (const Eigen::Index k : worst_rows(match, most_rows)) {
    std::vector<Table::Cell> line{std::to_string(match.row[static_cast<std::size_t>(k)])};
    for (Eigen::Index axis = 0; axis < match.residual_nm.rows(); ++axis)
      line.push_back(signed_fixed(match.residual_nm(axis, k), 1));
    rows.add(std::move(line));
  }
  console.out << "\nlargest residuals\n";
  rows.print(console.out, console.paint_out());
}

ExitCode match_tables(const Session& session, const InstrumentArguments& a) {
  const auto run = number_from(a.reference);
  const auto reference = run && *run >= 1 && *run == std::floor(*run)
                             ? columns_of_run(session, static_cast<std::int64_t>(*run))
                             : columns_of_file(a.reference, false);
  const auto other = columns_of_file(a.table, true);
  std::vector<std::string> axes, others;
  for (const auto& pair : pairs_of(a.axes, reference, other)) {
    axes.push_back(pair.reference);
    others.push_back(pair.other);
  }
  correction::InstrumentRules rules;
  rules.scale = !a.no_scale;
  rules.rotation = !a.no_rotation;
  const auto match = value_or_throw(
      correction::match_instruments(rows_of(reference, axes), rows_of(other, others), axes, rules));
  if (session.console.json)
    session.console.print_json(match_json(match));
  else
    print_match(session.console, match, a.most_rows);
  return ExitCode::done;
}

}  // namespace

void add_instruments_command(CLI::App& data, Session& session) {
  auto a = std::make_shared<InstrumentArguments>();
  CLI::App& command = add_command(
      data, session, "instruments",
      "A second instrument or a measured work-piece on the same points: scale, offset, rotation",
      [&session, a] { return match_tables(session, *a); });
  command
      .add_option("REFERENCE", a->reference,
                  "a run at the daemon, or a dataset CSV whose rows are those of its trajectory")
      ->required();
  command
      .add_option("TABLE", a->table,
                  "CSV with row_1, the row of the trajectory, and lengths such as x_mm; u_nm: "
                  "standard uncertainty of the row")
      ->required();
  command.add_option("--axis", a->axes, "x=gauge_x: which length of the table is x; repeatable")
      ->allow_extra_args(false);
  command.add_flag("--no-scale", a->no_scale, "the scale is held at 1");
  command.add_flag("--no-rotation", a->no_rotation, "the axes are held parallel");
  command.add_option("--rows", a->most_rows, "how many of the largest residuals are listed")
      ->capture_default_str();
}

}  // namespace driftwise::cli
