#include "server/indentation/microscope_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/text/shown_text.h"
#include "server/core/try.h"

namespace driftwise::indentation {
namespace {

struct Place {
  double x_um = 0, y_um = 0;
};

double distance_um(const Place& a, const Place& b) {
  return std::hypot(a.x_um - b.x_um, a.y_um - b.y_um);
}

Place planned_place(const PlannedIndent& planned) {
  return planned.line == Line::x ? Place{planned.at_um, 0} : Place{0, planned.at_um};
}

Result<MicroscopeIndent> row_of(std::span<const MicroscopeIndent> rows, int contact,
                                const std::string& what) {
  const auto found = std::ranges::find(rows, contact, &MicroscopeIndent::id);
  if (found == rows.end())
    return fail(ErrorCode::invalid_argument, reasons::kNoSuchRow,
                "there is no row with id " + std::to_string(contact) + ", " + what +
                    ": measure it, or correct the table");
  return *found;
}

// Where the indent was made, from the zero: after an interrupted contact beside its planned place.
Place made_place(const ProcedureRecord& record, const MadeIndent& made) {
  constexpr double kUmInMm = 1000;
  const Place place{(made.touch.x_mm - record.zero.x_mm) * kUmInMm,
                    (made.touch.y_mm - record.zero.y_mm) * kUmInMm};
  const bool known = place.x_um != 0 || place.y_um != 0;  // an indent is never made on the zero
  return known ? place : planned_place(made.planned);
}

// The indent that was made nearest to this place.
const MadeIndent& nearest(const ProcedureRecord& record, const Place& at) {
  return *std::ranges::min_element(record.indents, {}, [&](const MadeIndent& one) {
    return distance_um(made_place(record, one), at);
  });
}

// Axes of a picture: how its x and y become those of the robot above.
struct Frame {
  const char* correction;  // of the table's columns; empty: as they are
  int xx, xy, yx, yy;
  Place of(const Place& at) const {
    return {xx * at.x_um + xy * at.y_um, yx * at.x_um + yy * at.y_um};
  }
};

// Mirrored first: a picture's y often points down.
constexpr Frame kFrames[] = {
    {"", 1, 0, 0, 1},
    {"mirrored, y_um points the other way: change the sign of y_um", 1, 0, 0, -1},
    {"mirrored, x_um points the other way: change the sign of x_um", -1, 0, 0, 1},
    {"turned by 180 degrees: change the signs of x_um and y_um", -1, 0, 0, -1},
    {"turned by 90 degrees: write -y_um as x_um and x_um as y_um", 0, -1, 1, 0},
    {"turned by 90 degrees: write y_um as x_um and -x_um as y_um", 0, 1, -1, 0},
    {"mirrored, x_um and y_um are exchanged: exchange the two columns", 0, 1, 1, 0},
    {"mirrored and turned by 90 degrees: write -y_um as x_um and -x_um as y_um", 0, -1, -1, 0},
};

struct SeenIndent {
  const MadeIndent* made;
  MicroscopeIndent row;
  Place at;  // from the zero, in the picture
};

// The first row that lies nearest to another indent's place; none: every row is where its number
// says.
const SeenIndent* misplaced(const ProcedureRecord& record, std::span<const SeenIndent> seen,
                            const Frame& frame) {
  const auto found = std::ranges::find_if(seen, [&](const SeenIndent& one) {
    return nearest(record, frame.of(one.at)).planned.id != one.made->planned.id;
  });
  return found == seen.end() ? nullptr : &*found;
}

Result<void> check_places(const ProcedureRecord& record, std::span<const SeenIndent> seen,
                          int zero_id) {
  const SeenIndent* wrong = misplaced(record, seen, kFrames[0]);
  if (wrong == nullptr) return {};
  const std::string where = digits_text(wrong->at.x_um, 5) + ", " + digits_text(wrong->at.y_um, 5) +
                            " um from the zero (id " + std::to_string(zero_id) +
                            "), nearest to indent " + nearest(record, wrong->at).planned.id;
  const std::string which = "row id " + std::to_string(wrong->row.id) + " is indent " +
                            wrong->made->planned.id + " by its number, and lies at " + where;
  const auto frame = std::ranges::find_if(
      kFrames, [&](const Frame& one) { return misplaced(record, seen, one) == nullptr; });
  if (frame != std::end(kFrames))
    return fail(ErrorCode::invalid_argument, reasons::kWrongCoordinates,
                which + ", while every row is at its place in a picture that is " +
                    frame->correction + ". The numbers are right");
  return fail(ErrorCode::invalid_argument, reasons::kIdsShifted,
              which +
                  ": a contact that was interrupted may have left no mark. Compare with "
                  "driftwise indent show, and correct the ids");
}

}  // namespace

Result<std::vector<Indent>> indents_seen(const ProcedureRecord& record,
                                         std::span<const MicroscopeIndent> rows) {
  DRIFTWISE_TRY(const auto zero, row_of(rows, record.zero.contact, "the common zero"));
  std::vector<SeenIndent> seen_indents;
  for (const MadeIndent& made : record.indents) {
    const auto row = row_of(rows, made.touch.contact, "indent " + made.planned.id);
    // Of shifted numbers one is missing too, and that is not its cause.
    if (!row) DRIFTWISE_RETURN_IF_ERROR(check_places(record, seen_indents, zero.id));
    DRIFTWISE_RETURN_IF_ERROR(row);
    seen_indents.push_back({&made, *row, {row->x_um - zero.x_um, row->y_um - zero.y_um}});
  }
  DRIFTWISE_RETURN_IF_ERROR(check_places(record, seen_indents, zero.id));
  std::vector<Indent> indents;
  for (const SeenIndent& one : seen_indents) {
    const MadeIndent& made = *one.made;
    const MicroscopeIndent& seen = one.row;
    const Place& at = one.at;
    indents.push_back({.id = made.planned.id,
                       .line = made.planned.line,
                       .wanted_um = made.planned.at_um,
                       .rx_arcsec = made.rx_arcsec,
                       .ry_arcsec = made.ry_arcsec,
                       .measured_um = made.planned.line == Line::x ? at.x_um : at.y_um,
                       .pixel_nm = seen.pixel_nm,
                       .marking_px = seen.marking_px,
                       .pictures_joined = seen.pictures_joined,
                       .diagonal_um = std::isnan(seen.diagonal_um) ? 0 : seen.diagonal_um});
  }
  return indents;
}

}  // namespace driftwise::indentation
