#include "server/formats/cell_file/cell_file_correction.h"

#include <algorithm>

#include "server/core/reasons.h"
#include "server/formats/text/text.h"
#include "server/formats/text/toml_text.h"

namespace driftwise::formats {
namespace {

bool gives(const std::vector<Channel>& channels, std::string_view symbol) {
  return std::ranges::any_of(channels, [symbol](const Channel& c) { return c.symbol == symbol; });
}

std::string names_of(const std::vector<Channel>& channels) {
  std::string list;
  for (const auto& channel : channels) list += (list.empty() ? "" : ", ") + channel.name();
  return list.empty() ? "none" : list;
}

void read_beam(TomlReader&& reader, BeamDescription& out) {
  reader.robot_channel("length", out.length, Need::required);
  reader.vector3("offset_mm", out.offset_mm, 1e4);
  reader.vector3("offset_per_mm", out.offset_per_mm, 10);
  reader.number("u_offset_mm", out.u_offset_mm, {.min = 0});
  reader.vector3("direction_arcsec", out.direction_arcsec, 36000);
  reader.number("u_direction_arcsec", out.u_direction_arcsec, {.min = 0});
  reader.number("u_flatness_nm", out.u_flatness_nm, {.min = 0});
  reader.finish();
}

// Which rotations the correction of a length needs: those about the other two axes.
void need_tilts(TomlReader& reader, const char* key, const Channel& length,
                const CellDescription& cell) {
  const auto angles = cell.angle_channels();
  std::string robot(robot_of(length.symbol));  // its own rotations count
  if (!robot.empty()) robot += '.';
  for (const char* axis : {"x", "y", "z"}) {
    if (without_robot(length.symbol) == axis || gives(angles, robot + "r" + axis)) continue;
    reader.refuse(key, reasons::kMissingKey,
                  "the correction of " + shown(length.name()) + " needs " + robot + "r" + axis +
                      "_arcsec, expected an autocollimator with that [[device.angle]]; this cell "
                      "gives " +
                      names_of(angles));
  }
}

}  // namespace

void read_load(TomlReader&& load, LoadDescription& out) {
  load.number("max_n", out.max_n, {.min = 0, .max = 1e5, .above_min = true}, Need::required);
  load.number("u_n", out.u_n, {.min = 0});
  load.number("gravity_m_s2", out.gravity_m_s2, {.min = 9.7, .max = 9.9});
  load.finish();
}

void read_correction(TomlReader&& correction, CellDescription& out, TomlProblem& problem) {
  auto& wanted = out.correction.emplace();
  const auto lengths = out.length_channels();
  correction.truth("cosine", wanted.cosine);
  for (const auto* table : correction.tables("beam")) {
    const std::string place = "correction, beam " + std::to_string(wanted.beams.size() + 1);
    TomlReader reader(*table, place, problem);
    TomlReader line = reader;
    BeamDescription beam;
    read_beam(std::move(reader), beam);
    if (std::ranges::find(lengths, beam.length) == lengths.end())
      line.refuse("length", reasons::kBadChannel,
                  "found " + shown(beam.length.name()) +
                      ", which no interferometer of this cell gives; its lengths are " +
                      names_of(lengths));
    if (std::ranges::any_of(wanted.beams,
                            [&beam](const auto& other) { return other.length == beam.length; }))
      line.refuse("length", reasons::kDuplicateChannel,
                  "found " + shown(beam.length.name()) + ", which another beam has already");
    need_tilts(line, "length", beam.length, out);
    wanted.beams.push_back(beam);
  }
  if (wanted.cosine)
    for (const auto& length : lengths) need_tilts(correction, "cosine", length, out);
  correction.finish();
}

Result<CorrectionDescription> parse_correction_file(std::string_view text,
                                                    const std::string& file_name) {
  TomlProblem problem{.file_name = file_name, .first = {}};
  CorrectionDescription out;
  try {
    const auto root = parse_toml(text, file_name);
    TomlReader top(root, "", problem);
    const auto* table = top.table("correction");
    if (!table) {
      top.refuse("correction", reasons::kMissingKey,
                 "found no [correction] section, expected one with cosine or a beam");
    } else {
      TomlReader correction(*table, "correction", problem);
      correction.truth("cosine", out.cosine);
      for (const auto* beam : correction.tables("beam")) {
        const std::string place = "correction, beam " + std::to_string(out.beams.size() + 1);
        TomlReader reader(*beam, place, problem);
        TomlReader line = reader;
        auto& read = out.beams.emplace_back();
        read_beam(std::move(reader), read);
        if (read.length.symbol != "x" && read.length.symbol != "y" && read.length.symbol != "z")
          line.refuse("length", reasons::kBadChannel,
                      "found " + shown(read.length.name()) + ", expected x_mm, y_mm or z_mm");
      }
      correction.finish();
    }
  } catch (const toml::parse_error& error) {
    return tl::unexpected(syntax_error(error, file_name));
  }
  if (problem.any()) return tl::unexpected(*problem.first);
  return out;
}

}  // namespace driftwise::formats
