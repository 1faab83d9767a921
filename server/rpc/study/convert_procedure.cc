#include "server/rpc/study/convert_procedure.h"

#include "server/rpc/shared/convert_values.h"

namespace driftwise::rpc {
namespace {

v1::ProcedureStep::State state_from(application::ProcedureStep::State state) {
  using State = application::ProcedureStep::State;
  switch (state) {
    case State::done:
      return v1::ProcedureStep::STATE_DONE;
    case State::open:
      return v1::ProcedureStep::STATE_OPEN;
    case State::not_reached:
      return v1::ProcedureStep::STATE_NOT_REACHED;
  }
  return v1::ProcedureStep::STATE_UNSPECIFIED;
}

}  // namespace

v1::ProcedureStep step_from(const application::ProcedureStep& step) {
  v1::ProcedureStep out;
  out.set_number(step.number);
  out.set_name(step.name);
  out.set_state(state_from(step.state));
  out.set_found(utf8_from(step.found));
  out.set_missing(utf8_from(step.missing));
  out.set_command(step.command);
  for (const auto& source : step.sources) {
    auto& to = *out.add_sources();
    to.set_name(source.name);
    to.set_considered(!source.measured_by.empty());
    to.set_measured_by(source.measured_by);
  }
  for (const auto& figure : step.figures) {
    auto& to = *out.add_figures();
    to.set_coordinate(figure.coordinate);
    to.set_unit(figure.unit);
    if (figure.a90) to.set_a90(*figure.a90);
    if (figure.wanted) to.set_wanted_a90(*figure.wanted);
  }
  if (step.back_to) out.set_back_to_step(*step.back_to);
  out.set_largest_line(step.largest_line);
  if (step.largest_u_nm) out.set_largest_u_nm(*step.largest_u_nm);
  return out;
}

void put(const compensation::DesignStudy& study, v1::StudyDesignResponse& out) {
  using compensation::DesignLine;
  for (const auto& change : study.changes) {
    auto& to = *out.add_changes();
    to.set_what(change.what);
    to.set_before(change.before);
    to.set_after(change.after);
  }
  for (const auto& place : study.places) {
    auto& to = *out.add_places();
    to.set_name(place.name);
    add_values(place.pose, *to.mutable_pose());
  }
  for (const auto& output : study.outputs) {
    auto& to = *out.add_outputs();
    to.set_place(output.place);
    to.set_channel(output.channel.name());
    for (const auto& line : output.lines) {
      auto& one = *to.add_lines();
      one.set_name(compensation::shown_name(line.source));
      one.set_u_before_nm(line.u_before_nm);
      one.set_u_after_nm(line.u_after_nm);
    }
    to.set_u90_before_nm(output.u90_before_nm);
    to.set_u90_after_nm(output.u90_after_nm);
    if (const auto* line = output.largest(&DesignLine::u_before_nm))
      to.set_largest_before(compensation::shown_name(line->source));
    if (const auto* line = output.largest(&DesignLine::u_after_nm))
      to.set_largest_after(compensation::shown_name(line->source));
    if (output.u90_uncompensated_before_nm)
      to.set_u90_uncompensated_before_nm(*output.u90_uncompensated_before_nm);
    if (output.u90_uncompensated_after_nm)
      to.set_u90_uncompensated_after_nm(*output.u90_uncompensated_after_nm);
  }
  for (const auto& quantity : study.quantities) {
    auto& to = *out.add_quantities();
    to.set_name(quantity.name());
    to.set_value(quantity.value);
    to.set_what(quantity.what);
  }
  for (const auto& sentence : study.not_answered) out.add_not_answered(utf8_from(sentence));
}

}  // namespace driftwise::rpc
