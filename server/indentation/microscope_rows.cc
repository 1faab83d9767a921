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

}  // namespace

Result<std::vector<Indent>> indents_seen(const ProcedureRecord& record,
                                         std::span<const MicroscopeIndent> rows) {
  DRIFTWISE_TRY(const auto zero, row_of(rows, record.zero.contact, "the common zero"));
  std::vector<Indent> indents;
  for (const MadeIndent& made : record.indents) {
    DRIFTWISE_TRY(const auto seen, row_of(rows, made.touch.contact, "indent " + made.planned.id));
    const Place at{seen.x_um - zero.x_um, seen.y_um - zero.y_um};
    if (const auto& other = nearest(record, at); other.planned.id != made.planned.id)
      return fail(ErrorCode::invalid_argument, reasons::kIdsShifted,
                  "row id " + std::to_string(seen.id) + " is indent " + made.planned.id +
                      " by its number, and lies at " + digits_text(at.x_um, 5) + ", " +
                      digits_text(at.y_um, 5) + " um from the zero (id " + std::to_string(zero.id) +
                      "), nearest to indent " + other.planned.id +
                      ": a contact that was interrupted may have left no mark. Compare with "
                      "driftwise indent show, and correct the ids");
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
