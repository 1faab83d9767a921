#pragma once
// The indentation as a procedure: align -> common zero -> indents placed in closed loop -> lines in
// open loop. It asks a cell to move and to look, and keeps a record from which it goes on after it
// was interrupted. One thread; blocks in the cell's calls.
// Source: E. Lubrano, EPFL thesis 5098 (2011), sections 8.2 and 8.3.
//
// Survival: the record is handed to on_change before anything moves for the next entry and after
// every contact. Whoever starts again with it retracts first; an indent that was begun and not
// recorded is made again beside (retry_um), never in the same place. After a stop of the axes
// nothing moves until somebody starts again.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/indentation/alignment.h"
#include "server/indentation/approach.h"
#include "server/indentation/indent_table.h"

namespace driftwise::indentation {

// What the procedure asks of two robots. Positions of the robot above are those of its tool's
// frame, mm; heights and tilts of the robot below are its own.
class TouchingCell {
 public:
  virtual ~TouchingCell() = default;

  struct Answer {
    std::string by{};  // which model answered: "plan 1: ma=coarse:10", "geometry: raw coordinates"
    // What heights depend on: "plan 1", "geometry". A height that was touched by one says nothing
    // about another.
    std::string source{};
  };
  virtual Result<Answer> move_above(double x_mm, double y_mm, double z_mm) = 0;
  virtual Result<Answer> move_below(double rx_arcsec, double ry_arcsec, double z_mm) = 0;
  // Down to these tilts and this height; an axis that stands lower stays where it is: away from the
  // robot above, never towards it.
  virtual Result<Answer> retract_below(double rx_arcsec, double ry_arcsec, double z_mm) = 0;
  // Shifts the robot above by so much, without a new target: the closed loop's small steps.
  virtual Result<void> nudge_above(double dx_mm, double dy_mm) = 0;
  // Holding error of the robot above at rest, nm: readings x axes, all read after the call.
  virtual Result<Eigen::MatrixXd> look() = 0;
  virtual Result<void> wait(double cell_s) = 0;

  struct Here {
    double x_mm = 0, y_mm = 0, z_mm = 0;  // as the instruments measure the robot above
    double rx_arcsec = 0, ry_arcsec = 0;
    std::vector<std::pair<std::string, double>> motors_mm{};  // both robots
    std::vector<std::pair<std::string, double>> degc{};
  };
  virtual Result<Here> here() = 0;
  // UTC of the last readings, ISO 8601; empty: the cell has no clock.
  virtual std::string utc() { return {}; }
};

struct PlannedIndent {
  std::string id{};
  Line line = Line::x;
  double at_um = 0;
  bool closed_loop = false;
};

struct ProcedureRules {
  std::string tool{};
  double work_mm = 1;       // height of the robot above
  ApproachRule approach{};  // of the first touch: depart and highest
  // Retracted between contacts. Axes of the robot above that arrive one after the other let the
  // tool dip by tenths of a millimetre on its way.
  double clearance_mm = 0.6;
  double near_mm = 0.01;  // later approaches begin so far below the contact awaited
  double press_mm = 0;    // on from the contact, for an indent
  double dwell_s = 20;    // pressed
  double rest_nm = 80, rest_change_nm = 10;  // the robot above is at rest: error, change per look
  int rest_looks = 200;
  std::vector<std::pair<double, double>> touch_mm{{1, 1}, {1, -1}, {-1, -1}};
  double shift_x_mm = 0, shift_y_mm = 0.1;  // of the touched places after each correction
  AlignmentRule alignment{};
  double zero_x_mm = 0, zero_y_mm = 0;
  double closed_loop_nm = 20;
  int closed_loop_tries = 20;
  double retry_um = 20;  // an interrupted indent is made again so far beside the line
  std::vector<PlannedIndent> indents{};
};

enum class Stage { align, zero, indents, microscope };

struct TouchRecord {
  double x_mm = 0, y_mm = 0, height_mm = 0, u_nm = 0;
  int steps = 0;
  int contact = 0;  // number of the contact on the substrate, from 1
};

struct MadeIndent {
  PlannedIndent planned{};
  TouchRecord touch{};
  double placed_x_um = 0, placed_y_um = 0;  // from the zero, by the instruments
  double rx_arcsec = 0, ry_arcsec = 0;
  std::string by{};
};

// What the heights of a record depend on.
struct HeightBasis {
  double work_mm = 0;    // height of the robot above
  std::string source{};  // TouchingCell::Answer::source
};

// A contact on the substrate as it ended.
struct ContactRecord {
  TouchRecord touch{};
  Stage stage = Stage::align;
  int round = 0;                        // corrections made before it
  std::string indent{};                 // id of the indent; empty: no indent
  double rx_arcsec = 0, ry_arcsec = 0;  // commanded to the robot below
  std::string by{}, at{};               // model that answered; UTC, ISO 8601
  std::string trouble{};                // empty: found and recorded
};

// A round of the alignment as it was judged.
struct RoundRecord {
  int round = 0;  // corrections made before it
  bool accepted = false;
  double spread_nm = 0;                 // highest minus lowest contact
  double rx_arcsec = 0, ry_arcsec = 0;  // commanded to the robot below from then on
  double height_mm = 0;                 // of the plane at the zero
  std::string by{}, at{};
};

struct ProcedureRecord {
  std::string key{};  // of this indentation, made by the client at its first start
  // Age of the record: one more at each change. The number of contacts is none: it goes back where
  // an approach touched nothing.
  std::int64_t revision = 0;
  Stage stage = Stage::align;
  std::string tool{};
  int contacts = 0;  // on the substrate so far, interrupted ones included; the next is one more
  bool in_contact = false;  // one was begun, and the robot below was not retracted since
  double aside_um = 0;      // of the next contact: after an interrupted one, a fresh place
  int corrections = 0;
  int anew = 0;                         // rounds begun anew, at fresh places, without a correction
  double rx_arcsec = 0, ry_arcsec = 0;  // told to the robot below
  double height_mm = 0;                 // contact awaited at the zero
  bool touched = false;                 // height_mm is known
  // Of height_mm and touches; none: nothing was touched, or by a program that did not note it.
  std::optional<HeightBasis> heights_by{};
  double spread_nm = 0;
  std::vector<TouchRecord> touches{};  // of the round of the alignment under way
  std::vector<std::string> log{};      // sentences, with the stage
  TouchRecord zero{};
  TouchingCell::Here zero_here{};
  std::vector<MadeIndent> indents{};
  std::string by{};  // which model answered last
  std::vector<ContactRecord> contact_list{};
  std::vector<RoundRecord> rounds{};
};

// Takes the record to where it survives. An error ends the procedure like one of the cell's: the
// robot below is retracted.
using OnChange = std::function<Result<void>(const ProcedureRecord&)>;

// Goes on where the record is, until the microscope's turn. Heights that were touched with another
// height of the robot above or by another source are forgotten, and touched anew from depart_mm.
// Errors: those of the cell and of
// on_change; failed_precondition OTHER_TOOL (the record was begun with another), NO_CONVERGENCE
// (alignment or closed loop), NOTHING_FOUND (no contact), OUTSIDE_LIMITS (the holding error, or in
// contact where the approach was to begin), CONTACT_LOST (while it was pressed), NO_REST,
// CONFIGURATION_CHANGED (another source of motor coordinates in the middle).
// After an error the robot below has been retracted, or the sentence says that it could not be; one
// that stands lower has not moved. After an error aborted (the axes were stopped, by a person or by
// the daemon) nothing has moved any more.
Result<void> carry_out(TouchingCell& cell, const ProcedureRules& rules, ProcedureRecord& record,
                       const OnChange& on_change);

std::string_view to_string(Stage stage);

}  // namespace driftwise::indentation
