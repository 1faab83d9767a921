#include "server/correction/join_lengths.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "server/core/data/reading.h"

namespace driftwise::correction {
namespace {

// Pose of one row as a correction stage sees it.
struct Seen {
  Vector3 path_mm{};
  Tilt tilt;
};

const DatasetColumn* path_column(const Dataset& data, const char* length) {
  if (const auto* path = data.find(std::string(length) + "_path"); path && has_values(*path))
    return path;
  return data.find(length);
}

double& tilt_component(Tilt& tilt, std::size_t axis) {
  return axis == 0 ? tilt.rx_arcsec : axis == 1 ? tilt.ry_arcsec : tilt.rz_arcsec;
}

// A row as one part, or all of them, measured it.
struct Measured {
  Seen seen;
  std::array<double, 3> lengths{}, angles{};  // how many parts read it
};

void add_part(const JoinPart& part, std::size_t row, Measured& sum) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (const auto* path = path_column(part.data, kLengths[i]);
        path && !is_missing(path->values[row])) {
      sum.seen.path_mm[i] += mm_per_unit_of(path->channel) * path->values[row];
      sum.lengths[i] += 1;
    }
    if (const auto* angle = part.data.find(kAngles[i]); angle && !is_missing(angle->values[row])) {
      tilt_component(sum.seen.tilt, i) += arcsec_per_unit(angle->channel) * angle->values[row];
      sum.angles[i] += 1;
    }
  }
}

Measured mean_of_sum(Measured sum) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (sum.lengths[i] > 0) sum.seen.path_mm[i] /= sum.lengths[i];
    if (sum.angles[i] > 0) tilt_component(sum.seen.tilt, i) /= sum.angles[i];
  }
  return sum;
}

Measured measured_by(const JoinPart& part, std::size_t row) {
  Measured sum;
  add_part(part, row, sum);
  return mean_of_sum(sum);
}

Measured measured_by_all(const JoinParts& parts, const MatchedRows& rows, std::size_t k) {
  Measured sum;
  for (std::size_t p = 0; p < parts.size(); ++p) add_part(parts[p], rows.index[p][k], sum);
  return mean_of_sum(sum);
}

// The row that corrects a part's lengths: its own paths, so that what two parts measured stays two
// measurements, the others' where it has none, and the angles of all.
Seen with_angles_of_all(const Measured& own, const Measured& all) {
  Seen seen = all.seen;
  for (std::size_t i = 0; i < 3; ++i)
    if (own.lengths[i] > 0) seen.path_mm[i] = own.seen.path_mm[i];
  return seen;
}

bool was_corrected(const Dataset& data, const char* length) {
  const auto* path = data.find(std::string(length) + "_path");
  return path && has_values(*path);
}

std::array<bool, 3> angles_read(const JoinParts& parts) {
  std::array<bool, 3> read{};
  for (const auto& part : parts)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto* angle = part.data.find(kAngles[i]);
      read[i] = read[i] || (angle && has_values(*angle));
    }
  return read;
}

// Movement of a length by a tilt of by_arcsec about one axis, mm.
double moved_by(const Seen& seen, const Stage& stage, std::size_t length, std::size_t angle,
                double by_arcsec) {
  Tilt moved = seen.tilt;
  tilt_component(moved, angle) += by_arcsec;
  return pose_from_paths(seen.path_mm, moved, stage)[length] -
         pose_from_paths(seen.path_mm, seen.tilt, stage)[length];
}

}  // namespace

bool has_values(const DatasetColumn& column) {
  return std::ranges::any_of(column.values, [](double value) { return !is_missing(value); });
}

CorrectedLengths correct_lengths(const MatchedRows& rows, const AngleU& u_arcsec,
                                 JoinParts& parts) {
  std::array<double, 3> square{}, count{};
  CorrectedLengths out;
  const JoinParts as_measured = parts;
  const auto read = angles_read(as_measured);
  for (std::size_t k = 0; k < rows.row.size(); ++k) {
    const Measured all = measured_by_all(as_measured, rows, k);
    bool lacks_angle = false;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const auto& stage = as_measured[p].stage;
      if (!stage) continue;
      const std::size_t row = rows.index[p][k];
      const Measured own = measured_by(as_measured[p], row);
      const Seen seen = with_angles_of_all(own, all);
      const auto with_all = pose_from_paths(seen.path_mm, seen.tilt, *stage);
      const auto with_own = pose_from_paths(own.seen.path_mm, own.seen.tilt, *stage);
      for (std::size_t i = 0; i < 3; ++i) {
        const auto* source = as_measured[p].data.find(kLengths[i]);
        if (source == nullptr || is_missing(source->values[row])) continue;
        auto& column = parts[p].data.columns[static_cast<std::size_t>(
            source - as_measured[p].data.columns.data())];
        const auto needs = [&](std::size_t angle) {
          return read[angle] && all.angles[angle] == 0 && moved_by(seen, *stage, i, angle, 1) != 0;
        };
        if (needs(0) || needs(1) || needs(2)) {
          column.values[row] = kMissing;
          lacks_angle = true;
          continue;
        }
        const double before_mm =
            was_corrected(as_measured[p].data, kLengths[i]) ? with_own[i] : own.seen.path_mm[i];
        column.values[row] += (with_all[i] - before_mm) / mm_per_unit_of(column.channel);
        for (std::size_t angle = 0; angle < 3; ++angle)
          square[i] += std::pow(moved_by(seen, *stage, i, angle, u_arcsec[angle]), 2);
        count[i] += 1;
      }
    }
    if (lacks_angle) ++out.rows_without_angle;
  }
  for (std::size_t i = 0; i < 3; ++i)
    out.u_mm[i] = count[i] > 0 ? std::sqrt(square[i] / count[i]) : 0;
  return out;
}

}  // namespace driftwise::correction
