#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "clients/cli/commands/data/join_command.h"
#include "clients/cli/core/input_text.h"
#include "clients/cli/core/value_or_throw.h"
#include "server/core/reasons.h"
#include "server/correction/angle_drift.h"
#include "server/formats/csv/dataset_csv.h"
#include "server/formats/csv/set_names.h"
#include "server/formats/diagnosis/amendment_json.h"

namespace driftwise::cli {
namespace {

// Metadata line that holds what was taken off, as the record's corrections are written.
constexpr const char* kAngleCorrectionKey = "angle_correction";

struct AngleDriftArguments {
  std::string file, axis, thermometer, source, output;
  std::optional<double> arcsec_per_k, u_arcsec_per_k;
};

correction::AngleDrift drift_of(const Dataset& data, const AngleDriftArguments& a) {
  if (!a.arcsec_per_k) {
    if (a.u_arcsec_per_k || !a.source.empty())
      throw Failure{ExitCode::usage, "usage", "USAGE",
                    "--u and --source belong to --arcsec-per-k; without it the drift is found from "
                    "the returns to zero"};
    return value_or_throw(correction::drift_from_returns(data, a.axis, a.thermometer));
  }
  if (!a.u_arcsec_per_k || a.source.empty())
    throw Failure{ExitCode::usage, "usage", "USAGE",
                  "a stated drift needs its uncertainty and where it comes from: give --u and "
                  "--source \"drawing 17, mount of aluminium\""};
  for (const auto& symbol : {a.axis, a.thermometer})
    if (data.find(symbol) == nullptr)
      throw Failure{ExitCode::bad_input, "invalid_argument", reasons::kUnknownChannel,
                    fmt::format("{}: found no channel {}, expected a rotation and a thermometer of "
                                "the data",
                                a.file, symbol)};
  if (!is_angle(data.find(a.axis)->channel.unit) ||
      !is_structure_temperature(data.find(a.thermometer)->channel))
    throw Failure{
        ExitCode::bad_input, "invalid_argument", reasons::kUnknownChannel,
        fmt::format("{}: found {} and {}, expected a rotation and a thermometer", a.file,
                    data.find(a.axis)->channel.name(), data.find(a.thermometer)->channel.name())};
  correction::AngleDrift stated;
  stated.arcsec_per_k = *a.arcsec_per_k;
  stated.u_arcsec_per_k = *a.u_arcsec_per_k;
  return stated;
}

void refuse_second(const Dataset& data, const AngleDriftArguments& a) {
  for (const auto& [key, value] : data.metadata) {
    if (key != kAngleCorrectionKey) continue;
    const auto before = value_or_throw(formats::read_amendment_json(value));
    for (const auto& shift : before.angles)
      if (shift.axis == a.axis)
        throw Failure{ExitCode::bad_input, "failed_precondition", reasons::kBadCorrection,
                      fmt::format("{}: the drift of {} is taken off already ({}): begin with the "
                                  "data as they were measured",
                                  a.file, a.axis, shift.source)};
  }
}

std::size_t values_in(const Dataset& data, const std::string& symbol) {
  const auto& values = data.find(symbol)->values;
  return static_cast<std::size_t>(
      std::ranges::count_if(values, [](double value) { return !is_missing(value); }));
}

// Number of rows whose angle is empty now: their thermometer has no value.
std::size_t write_corrected(Dataset data, const AngleDriftArguments& a, std::string_view text,
                            const correction::AngleShift& shift) {
  const auto before = values_in(data, a.axis);
  correction::DataAmendment amendment;
  amendment.angles = {shift};
  std::vector<correction::RowOrigin> origins;
  for (std::size_t row = 0; row < data.rows; ++row)
    origins.push_back({RunId{data.run.empty() ? 0 : data.run[row]}, 0});
  if (const auto done = correction::amend(amendment, origins, {}, data); !done)
    throw failure_of(done.error());
  data.metadata.emplace_back(kAngleCorrectionKey, formats::write_amendment_json(amendment));
  const auto names = value_or_throw(formats::read_set_names(text, a.file));
  write_output_file(a.output, formats::with_set_names(formats::write_dataset_csv(data), names),
                    {a.file});
  return before - values_in(data, a.axis);
}

ExitCode angle_drift(const Console& console, const AngleDriftArguments& a) {
  const InputText input(a.file);
  auto data = value_or_throw(formats::read_dataset_csv(input.text(), a.file));
  refuse_second(data, a);
  const auto drift = drift_of(data, a);
  const std::string source =
      drift.returns == 0
          ? a.source
          : fmt::format("{} returns to zero in {} datums of {}, {} over {:.2f} K", drift.returns,
                        drift.datums, a.file, a.thermometer, drift.span_k);
  const auto shift = correction::shift_from(drift, a.axis, a.thermometer, source);
  const std::size_t emptied =
      a.output.empty() ? 0 : write_corrected(std::move(data), a, input.text(), shift);
  if (console.json) {
    nlohmann::ordered_json json{{"channel", a.axis},
                                {"thermometer", a.thermometer},
                                {"arcsec_per_k", drift.arcsec_per_k},
                                {"u_arcsec_per_k", drift.u_arcsec_per_k},
                                {"source", source}};
    if (drift.returns > 0) json["residual_arcsec"] = drift.residual_arcsec;
    if (!a.output.empty()) {
      json["file"] = a.output;
      json["emptied_rows"] = emptied;
    }
    console.print_json(json);
    return ExitCode::done;
  }
  console.out << fmt::format("{} drifts by {:+.4g} +- {:.2g} arcsec/K with {} ({})\n", a.axis,
                             drift.arcsec_per_k, drift.u_arcsec_per_k, a.thermometer, source);
  if (drift.returns > 0)
    console.out << fmt::format("the returns scatter by {:.3g} arcsec about it\n",
                               drift.residual_arcsec);
  if (!a.output.empty())
    console.err << "wrote " << a.output << ": " << a.axis
                << " without it, counted from each datum's first row\n";
  if (emptied > 0)
    console.err << fmt::format("{} rows have no {} there: {} was not measured in them\n", emptied,
                               a.axis, a.thermometer);
  return ExitCode::done;
}

}  // namespace

void add_angle_drift_command(CLI::App& data, Session& session) {
  auto a = std::make_shared<AngleDriftArguments>();
  CLI::App& command =
      add_command(data, session, "angle-drift",
                  "The drift of a rotation's reading with a temperature, found and taken off",
                  [&session, a] { return angle_drift(session.console, *a); });
  command.add_option("FILE", a->file, "dataset CSV, as data export writes it")->required();
  command.add_option("--channel", a->axis, "the rotation, such as ry")->required();
  command.add_option("--thermometer", a->thermometer, "on the mount that turns, such as t05")
      ->required();
  command.add_option("--arcsec-per-k", a->arcsec_per_k,
                     "the drift, stated; else it is found from the returns to zero");
  command.add_option("--u", a->u_arcsec_per_k, "standard uncertainty of a stated drift, arcsec/K")
      ->check(CLI::NonNegativeNumber);
  command.add_option("--source", a->source, "where a stated drift comes from");
  command.add_option("-o,--output", a->output, "write the data without the drift to this file");
}

}  // namespace driftwise::cli
