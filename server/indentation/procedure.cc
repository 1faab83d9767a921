#include "server/indentation/procedure.h"

#include <algorithm>
#include <cmath>

#include "server/core/reasons.h"
#include "server/core/text/quantity_text.h"
#include "server/core/text/shown_text.h"
#include "server/core/try.h"
#include "server/core/units.h"

namespace driftwise::indentation {
namespace {

constexpr double kLookAgain_s = 1;
constexpr double kUmOfMm = 1e3;

class Procedure {
 public:
  Procedure(TouchingCell& cell, const ProcedureRules& rules, ProcedureRecord& record,
            const OnChange& on_change)
      : cell_(cell), rules_(rules), record_(record), on_change_(on_change) {}

  Result<void> run() {
    const bool interrupted = record_.in_contact;
    give_up_contact("the client was lost during the contact");
    // The robot below goes away before anything else moves.
    DRIFTWISE_RETURN_IF_ERROR(lower());
    const std::string forgotten = forget_other_heights();
    if (!forgotten.empty()) DRIFTWISE_RETURN_IF_ERROR(lower());
    DRIFTWISE_RETURN_IF_ERROR(above(rules_.zero_x_mm, rules_.zero_y_mm));
    DRIFTWISE_RETURN_IF_ERROR(rest());
    record_.in_contact = false;
    if (interrupted)
      DRIFTWISE_RETURN_IF_ERROR(say("the contact before was interrupted: retracted"));
    if (!forgotten.empty()) DRIFTWISE_RETURN_IF_ERROR(say(forgotten));
    if (record_.aside_um > 0)
      DRIFTWISE_RETURN_IF_ERROR(say("the next contact is " + digits_text(record_.aside_um) +
                                    " um beside, on a fresh surface"));
    if (record_.stage == Stage::align) DRIFTWISE_RETURN_IF_ERROR(align());
    if (record_.stage == Stage::zero) DRIFTWISE_RETURN_IF_ERROR(find_zero());
    if (record_.stage == Stage::indents) DRIFTWISE_RETURN_IF_ERROR(make_indents());
    return {};
  }

  // A contact that was begun and is not listed has used its place: it is listed with the trouble,
  // and the next one is made beside.
  void give_up_contact(const std::string& trouble) {
    const auto& list = record_.contact_list;
    const bool is_listed = !list.empty() && list.back().touch.contact == record_.contacts;
    if (!record_.in_contact || is_listed) return;
    note_contact({.contact = record_.contacts}, "", trouble);
    record_.aside_um += rules_.retry_um;
  }

  // The clearance below the contact awaited, or lower.
  Result<void> lower() {
    const double awaited_mm = record_.touched ? record_.height_mm : rules_.approach.depart_mm;
    DRIFTWISE_TRY(const auto answer, cell_.retract_below(record_.rx_arcsec, record_.ry_arcsec,
                                                         awaited_mm - rules_.clearance_mm));
    record_.by = answer.by;
    source_ = answer.source;
    return {};
  }

 private:
  Result<void> changed() {
    ++record_.revision;
    return on_change_(record_);
  }

  // What was touched counts from another height of the robot above, or in the coordinates of
  // another source: an approach that trusts it could begin inside the work-piece. Said; empty: the
  // heights stand.
  std::string forget_other_heights() {
    const bool knows_heights = record_.touched || !record_.touches.empty();
    if (!record_.heights_by && knows_heights)
      record_.heights_by = {.work_mm = rules_.work_mm, .source = source_};
    if (!record_.heights_by) return {};
    const HeightBasis before = *record_.heights_by;
    const bool other_source = before.source != source_;
    if (before.work_mm == rules_.work_mm && !other_source) return {};
    record_.heights_by.reset();
    record_.touched = false;
    // The tilts of an alignment are the source's coordinates too.
    const bool aligns_anew = other_source && record_.stage == Stage::zero;
    if (aligns_anew) record_.stage = Stage::align;
    if (aligns_anew || !record_.touches.empty()) ++record_.anew;
    record_.touches.clear();
    const auto basis = [](const HeightBasis& one) {
      return "work_mm " + number_text(one.work_mm) +
             (one.source.empty() ? "" : " and moved by " + one.source);
    };
    return "the heights were touched with " + basis(before) + ", now it is " +
           basis({.work_mm = rules_.work_mm, .source = source_}) +
           ": they are forgotten, and touched anew from depart_mm";
  }

  // Of the awaited contact: where the approach begins, and its highest place.
  ApproachRule awaited() const {
    ApproachRule rule = rules_.approach;
    if (!record_.touched) return rule;
    rule.depart_mm = record_.height_mm - rules_.near_mm;
    rule.highest_mm = record_.height_mm + rules_.near_mm;
    return rule;
  }

  // Heights of two sources are not compared.
  Result<void> answered(const TouchingCell::Answer& answer) {
    record_.by = answer.by;
    source_ = answer.source;
    if (!record_.heights_by || record_.heights_by->source == source_) return {};
    return fail(ErrorCode::failed_precondition, reasons::kConfigurationChanged,
                "the robots are moved by " + source_ + " now, the heights were touched by " +
                    record_.heights_by->source +
                    ": the same command goes on, and touches them anew");
  }

  Result<void> above(double x_mm, double y_mm) {
    DRIFTWISE_TRY(const auto answer, cell_.move_above(x_mm, y_mm, rules_.work_mm));
    return answered(answer);
  }

  Result<void> retract() {
    DRIFTWISE_RETURN_IF_ERROR(lower());
    return rest();
  }

  Result<void> say(std::string sentence) {
    record_.log.push_back(std::string(to_string(record_.stage)) + ": " + std::move(sentence));
    return changed();
  }

  Result<void> below(double z_mm) {
    DRIFTWISE_TRY(const auto answer, cell_.move_below(record_.rx_arcsec, record_.ry_arcsec, z_mm));
    return answered(answer);
  }

  // The servo of the robot above gives back what it pushed with, after a contact.
  Result<void> rest() {
    DRIFTWISE_TRY(Eigen::MatrixXd window, cell_.look());
    Eigen::RowVectorXd before = window.colwise().mean();
    for (int i = 0; i < rules_.rest_looks; ++i) {
      DRIFTWISE_TRY(window, cell_.look());
      const Eigen::RowVectorXd mean = window.colwise().mean();
      const bool quiet = (mean - before).cwiseAbs().maxCoeff() < rules_.rest_change_nm;
      if (quiet && mean.cwiseAbs().maxCoeff() < rules_.rest_nm) return {};
      before = mean;
      DRIFTWISE_RETURN_IF_ERROR(cell_.wait(kLookAgain_s));
    }
    return fail(ErrorCode::failed_precondition, reasons::kNoRest,
                "the robot above does not come to rest: its holding error is " +
                    digits_text(before.cwiseAbs().maxCoeff()) + " nm, at rest it is below " +
                    digits_text(rules_.rest_nm) + " nm. Is it free of the work-piece?");
  }

  // One contact at (x, y): from below, to the decision; pressed when it is an indent. The robot
  // below stands the clearance below, or lower.
  Result<TouchRecord> touch(double press_mm) {
    using Kind = Approach::Next::Kind;
    DRIFTWISE_TRY(auto approach, Approach::create(awaited()));
    auto next = approach.begin();
    while (next.kind == Kind::rest) {
      DRIFTWISE_TRY(const auto window, cell_.look());
      DRIFTWISE_TRY(next, approach.next(window));
    }
    record_.in_contact = true;
    ++record_.contacts;
    DRIFTWISE_RETURN_IF_ERROR(changed());
    while (next.kind == Kind::move || next.kind == Kind::look) {
      if (next.kind == Kind::move)
        DRIFTWISE_RETURN_IF_ERROR(below(next.height_mm));
      else if (approach.detector().shift_nm().size() > 0)
        DRIFTWISE_RETURN_IF_ERROR(cell_.wait(kLookAgain_s));
      DRIFTWISE_TRY(const auto window, cell_.look());
      DRIFTWISE_TRY(next, approach.next(window));
    }
    if (next.kind == Kind::no_contact) {  // nothing was touched: the place stays fresh
      --record_.contacts;
      record_.in_contact = false;
    }
    if (next.kind == Kind::touching || (next.kind == Kind::abort && approach.steps() == 0))
      next.why +=
          record_.touched ? " ([approach] near_mm larger)" : " ([approach] depart_mm lower)";
    if (next.kind != Kind::contact)
      return fail(ErrorCode::failed_precondition,
                  next.kind == Kind::no_contact ? reasons::kNothingFound : reasons::kOutsideLimits,
                  next.why);
    record_.heights_by = {.work_mm = rules_.work_mm, .source = source_};
    if (press_mm > 0) DRIFTWISE_RETURN_IF_ERROR(press(approach, press_mm));
    return TouchRecord{.height_mm = next.height_mm,
                       .u_nm = next.u_nm,
                       .steps = approach.steps(),
                       .contact = record_.contacts};
  }

  Result<void> press(const Approach& approach, double press_mm) {
    const double to_mm = approach.height_mm() + press_mm;
    ContactDetector detector = approach.detector();
    const int side = detector.side();
    for (double z_mm = approach.height_mm(); z_mm < to_mm - 1e-9;) {
      z_mm = std::min(to_mm, z_mm + rules_.approach.step_mm);
      DRIFTWISE_RETURN_IF_ERROR(below(z_mm));
      DRIFTWISE_TRY(const Eigen::MatrixXd window, cell_.look());
      const double largest_nm = window.colwise().mean().cwiseAbs().maxCoeff();
      if (largest_nm > rules_.approach.contact.abort_nm)
        return fail(ErrorCode::failed_precondition, reasons::kOutsideLimits,
                    "pressed up to " + number_text(z_mm) + " mm: the holding error is " +
                        digits_text(largest_nm) + " nm, the limit is " +
                        digits_text(rules_.approach.contact.abort_nm) +
                        " nm. Press less, or look for what blocks the robot");
      DRIFTWISE_RETURN_IF_ERROR(detector.add(window));
      if (detector.side() != side) {  // once: somebody knocked
        DRIFTWISE_RETURN_IF_ERROR(cell_.wait(kLookAgain_s));
        DRIFTWISE_TRY(const Eigen::MatrixXd again, cell_.look());
        DRIFTWISE_RETURN_IF_ERROR(detector.add(again));
      }
      if (detector.side() != side)
        return fail(
            ErrorCode::failed_precondition, reasons::kContactLost,
            "pressed up to " + number_text(z_mm) + " mm, " +
                digits_text((z_mm - approach.height_mm()) * 1e6) +
                " nm beyond the contact: the holding error is " +
                digits_text(detector.shift_nm().cwiseAbs().maxCoeff()) +
                " nm off its baseline, in contact it is above " + digits_text(detector.faint_nm()) +
                " nm. The contact is lost: see that tool and work-piece are fixed and that the "
                "robot below moves; the same command goes on, beside this place");
    }
    return cell_.wait(rules_.dwell_s);
  }

  void note_contact(const TouchRecord& touch, const std::string& indent,
                    const std::string& trouble = {}) {
    record_.contact_list.push_back({.touch = touch,
                                    .stage = record_.stage,
                                    .round = record_.corrections,
                                    .indent = indent,
                                    .rx_arcsec = record_.rx_arcsec,
                                    .ry_arcsec = record_.ry_arcsec,
                                    .by = record_.by,
                                    .at = cell_.utc(),
                                    .trouble = trouble});
  }

  // rx_arcsec, ry_arcsec: commanded from now on.
  void note_round(const AlignmentStep& step, double rx_arcsec, double ry_arcsec) {
    record_.rounds.push_back({.round = record_.corrections,
                              .accepted = step.kind == AlignmentStep::Kind::accepted,
                              .spread_nm = step.plane.spread_nm,
                              .rx_arcsec = rx_arcsec,
                              .ry_arcsec = ry_arcsec,
                              .height_mm = step.plane.c_mm,
                              .by = record_.by,
                              .at = cell_.utc()});
  }

  // It counts from here on, whatever becomes of the retract.
  Result<void> recorded() {
    record_.aside_um = 0;
    return changed();
  }

  Result<void> retracted() {
    record_.in_contact = false;
    return changed();
  }

  Result<void> align() {
    for (;;) {
      while (record_.touches.size() < rules_.touch_mm.size()) {
        const auto& [x_mm, y_mm] = rules_.touch_mm[record_.touches.size()];
        const int shifts = record_.corrections + record_.anew;
        const double x = x_mm + shifts * rules_.shift_x_mm + aside_mm();
        const double y = y_mm + shifts * rules_.shift_y_mm;
        DRIFTWISE_RETURN_IF_ERROR(above(x, y));
        DRIFTWISE_RETURN_IF_ERROR(rest());
        DRIFTWISE_TRY(auto found, touch(0));
        found.x_mm = x;
        found.y_mm = y;
        record_.touches.push_back(found);
        note_contact(found, "");
        DRIFTWISE_RETURN_IF_ERROR(recorded());
        DRIFTWISE_RETURN_IF_ERROR(below(found.height_mm - rules_.clearance_mm));
        DRIFTWISE_RETURN_IF_ERROR(rest());
        DRIFTWISE_RETURN_IF_ERROR(retracted());
      }
      std::vector<TouchPoint> points;
      for (const TouchRecord& one : record_.touches)
        points.push_back(
            {.x_mm = one.x_mm, .y_mm = one.y_mm, .height_mm = one.height_mm, .u_nm = one.u_nm});
      DRIFTWISE_TRY(const auto step, next_alignment(rules_.alignment, record_.corrections,
                                                    record_.rx_arcsec, record_.ry_arcsec, points));
      const bool corrects = step.kind == AlignmentStep::Kind::correct;
      note_round(step, corrects ? step.rx_arcsec : record_.rx_arcsec,
                 corrects ? step.ry_arcsec : record_.ry_arcsec);
      record_.spread_nm = step.plane.spread_nm;
      record_.touches.clear();
      if (step.kind == AlignmentStep::Kind::refused) {
        ++record_.anew;  // these places are used
        return fail(ErrorCode::failed_precondition, reasons::kNoConvergence, step.sentence);
      }
      record_.height_mm = step.plane.c_mm;
      record_.touched = true;
      if (step.kind == AlignmentStep::Kind::accepted) {
        record_.stage = Stage::zero;
        return say(step.sentence + "; answered by " + record_.by);
      }
      ++record_.corrections;
      record_.rx_arcsec = step.rx_arcsec;
      record_.ry_arcsec = step.ry_arcsec;
      DRIFTWISE_RETURN_IF_ERROR(below(record_.height_mm - rules_.clearance_mm));
      DRIFTWISE_RETURN_IF_ERROR(say(step.sentence + "; answered by " + record_.by));
    }
  }

  // Poses of both robots at the contact, and the temperatures then.
  Result<void> find_zero() {
    DRIFTWISE_RETURN_IF_ERROR(above(rules_.zero_x_mm, rules_.zero_y_mm + aside_mm()));
    DRIFTWISE_RETURN_IF_ERROR(rest());
    DRIFTWISE_TRY(const auto placed, cell_.here());
    DRIFTWISE_TRY(auto found, touch(rules_.press_mm));
    DRIFTWISE_TRY(record_.zero_here, cell_.here());
    // Where the tool was before it was pushed.
    record_.zero_here.x_mm = placed.x_mm;
    record_.zero_here.y_mm = placed.y_mm;
    record_.zero_here.rx_arcsec = placed.rx_arcsec;
    record_.zero_here.ry_arcsec = placed.ry_arcsec;
    found.x_mm = rules_.zero_x_mm;
    found.y_mm = rules_.zero_y_mm + aside_mm();
    record_.zero = found;
    note_contact(found, "");
    record_.height_mm = found.height_mm;
    record_.touched = true;
    record_.stage = Stage::indents;
    DRIFTWISE_RETURN_IF_ERROR(recorded());
    DRIFTWISE_RETURN_IF_ERROR(retract());
    DRIFTWISE_RETURN_IF_ERROR(retracted());
    return say("contact at " + number_text(found.height_mm) + " mm after " +
               std::to_string(found.steps) + " steps");
  }

  double aside_mm() const { return record_.aside_um / kUmOfMm; }

  Result<void> make_indents() {
    for (const PlannedIndent& planned : rules_.indents) {
      const bool made = std::ranges::any_of(
          record_.indents, [&](const MadeIndent& one) { return one.planned.id == planned.id; });
      if (!made) DRIFTWISE_RETURN_IF_ERROR(make(planned));
    }
    record_.stage = Stage::microscope;
    return say("all " + std::to_string(record_.indents.size()) +
               " indents are made; measure them in the microscope and import its table");
  }

  Result<void> make(const PlannedIndent& planned) {
    const double way_mm = planned.at_um / kUmOfMm;
    const double dx = planned.line == Line::x ? way_mm : aside_mm();
    const double dy = planned.line == Line::y ? way_mm : aside_mm();
    DRIFTWISE_RETURN_IF_ERROR(above(record_.zero.x_mm + dx, record_.zero.y_mm + dy));
    const std::string by = record_.by;
    DRIFTWISE_RETURN_IF_ERROR(rest());
    if (planned.closed_loop) DRIFTWISE_RETURN_IF_ERROR(close_loop(planned.id, dx, dy));
    DRIFTWISE_TRY(const auto placed, cell_.here());
    DRIFTWISE_TRY(auto found, touch(rules_.press_mm));
    found.x_mm = record_.zero.x_mm + dx;
    found.y_mm = record_.zero.y_mm + dy;
    record_.height_mm = found.height_mm;
    record_.touched = true;
    note_contact(found, planned.id);
    record_.indents.push_back({.planned = planned,
                               .touch = found,
                               .placed_x_um = (placed.x_mm - record_.zero_here.x_mm) * kUmOfMm,
                               .placed_y_um = (placed.y_mm - record_.zero_here.y_mm) * kUmOfMm,
                               .rx_arcsec = placed.rx_arcsec - record_.zero_here.rx_arcsec,
                               .ry_arcsec = placed.ry_arcsec - record_.zero_here.ry_arcsec,
                               .by = by});
    DRIFTWISE_RETURN_IF_ERROR(recorded());
    DRIFTWISE_RETURN_IF_ERROR(retract());
    DRIFTWISE_RETURN_IF_ERROR(retracted());
    return say("indent " + planned.id + " at " + digits_text(planned.at_um, 6) + " um along " +
               std::string(to_string_of(planned.line)) + ", contact after " +
               std::to_string(found.steps) + " steps");
  }

  static std::string_view to_string_of(Line line) { return line == Line::x ? "x" : "y"; }

  // Until the instruments show the wanted distance from the zero.
  Result<void> close_loop(const std::string& id, double dx_mm, double dy_mm) {
    double off_x_mm = 0, off_y_mm = 0;
    for (int i = 0; i < rules_.closed_loop_tries; ++i) {
      DRIFTWISE_TRY(const auto here, cell_.here());
      off_x_mm = here.x_mm - record_.zero_here.x_mm - dx_mm;
      off_y_mm = here.y_mm - record_.zero_here.y_mm - dy_mm;
      if (nm_from_mm(std::max(std::abs(off_x_mm), std::abs(off_y_mm))) <= rules_.closed_loop_nm)
        return {};
      DRIFTWISE_RETURN_IF_ERROR(cell_.nudge_above(-off_x_mm, -off_y_mm));
      DRIFTWISE_RETURN_IF_ERROR(rest());
    }
    return fail(ErrorCode::failed_precondition, reasons::kNoConvergence,
                "indent " + id + " is " + digits_text(nm_from_mm(off_x_mm)) + ", " +
                    digits_text(nm_from_mm(off_y_mm)) + " nm off after " +
                    std::to_string(rules_.closed_loop_tries) + " tries, wanted is +-" +
                    digits_text(rules_.closed_loop_nm) +
                    " nm: are the interferometers' values quiet?");
  }

  TouchingCell& cell_;
  const ProcedureRules& rules_;
  ProcedureRecord& record_;
  const OnChange& on_change_;
  std::string source_;  // of the last motor coordinates
};

}  // namespace

Result<void> carry_out(TouchingCell& cell, const ProcedureRules& rules, ProcedureRecord& record,
                       const OnChange& on_change) {
  if (record.tool.empty()) record.tool = rules.tool;
  if (record.tool != rules.tool)
    return fail(ErrorCode::failed_precondition, reasons::kOtherTool,
                "this indentation was begun with tool " + shown(record.tool) + ", now it is " +
                    shown(rules.tool) +
                    ": contacts of two tools have no common zero. Begin a new one");
  Procedure procedure(cell, rules, record, on_change);
  auto done = procedure.run();
  if (done) return done;
  Error error = done.error();
  const std::string cause = error.message;
  procedure.give_up_contact(error.message);
  // The axes were stopped: somebody may be in the cell, and only a person makes them move again.
  if (error.code == ErrorCode::aborted) {
    error.message +=
        "; the robot below stays where it is: the same command retracts it before it goes on";
  } else if (const auto away = procedure.lower(); away) {
    // A robot that is left in contact is worse than a procedure that ends.
    record.in_contact = false;
  } else {
    error.message += "; the robot below could not be retracted: " + away.error().message;
  }
  record.log.push_back(std::string(to_string(record.stage)) + ": " + error.message);
  ++record.revision;
  if (const auto kept = on_change(record); !kept && kept.error().message != cause)
    error.message += "; and " + kept.error().message;
  return tl::unexpected(error);
}

std::string_view to_string(Stage stage) {
  switch (stage) {
    case Stage::align:
      return "align";
    case Stage::zero:
      return "zero";
    case Stage::indents:
      return "indents";
    case Stage::microscope:
      return "microscope";
  }
  return "";
}

}  // namespace driftwise::indentation
