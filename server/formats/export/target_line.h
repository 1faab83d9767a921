#pragma once
// The text protocol for controllers without gRPC: one line asks, one line answers. Codec only; the
// socket is server/line/target_line_server. Manual with examples: docs/target-line.md.
//
//   TARGET x_mm=1.5 u=1
//   OK q1_mm=1.500123456 u90_nm=8.1 valid_until=2026-11-21T08:05:04Z model=3 flags=-
// Of an arm, with the angles that the nearest of its solutions is wanted to (else where it stands):
//   TARGET x_mm=600 y_mm=300 z_mm=500 rx_arcsec=648000 ry_arcsec=0 rz_arcsec=0 near_q2_deg=-90
//   OK q1_rad=0.4639 ... valid_until=2026-11-21T08:05:04Z model=3 flags=-
//   ERR OUTSIDE_DOMAIN x_mm outside what the model was fitted on, ...
// Of a serving plan, whose robots' coordinates carry the robot's id (docs/plans.md):
//   JOINT mn.x_mm=1 mn.y_mm=0 mn.z_mm=0.5 ma.rx_arcsec=0 ma.ry_arcsec=100 ma.z_mm=3 u=1
//   OK mn.q1_mm=1.003 u90_mn.q1_nm=95.1 ... add_mn.x_mm=0.003 u90_add_mn.x_nm=823.2 ...
//   by_ma=fine:11 by_mn=one:12 valid_until=2026-11-21T08:05:04Z plan=7 flags=-

#include <string>
#include <string_view>

#include "server/compensation/target.h"
#include "server/core/result.h"
#include "server/plans/joint_target.h"

namespace driftwise::formats {

constexpr std::size_t kMaxTargetLine =
    512;  // bytes of a request with its end; a longer one ends the connection

// line: without its end (LF or CRLF). Words are parted by blanks; names are exact, their order is
// free. Errors, invalid_argument: LINE_TOO_LONG, UNKNOWN_VERB, BAD_WORD (no name=value),
// UNKNOWN_NAME, DUPLICATE_NAME, BAD_NUMBER, BAD_FLAG (u is 0 or 1).
Result<compensation::TargetRequest> parse_target_line(std::string_view line);

// Appends the answer with its LF: nothing is allocated once out has the room (kMaxTargetAnswer is
// enough for one axis). The numbers of q read back exactly.
void append_target_answer(std::string& out, const compensation::Snapshot& snapshot,
                          const compensation::Target& target, bool with_uncertainty);

// As parse_target_line, of a line that begins with JOINT; names are those of the snapshot's robots.
Result<plans::JointRequest> parse_joint_line(std::string_view line,
                                             const plans::JointSnapshot& snapshot);
// As append_target_answer. A predicted coordinate that is not corrected begins with seen_ instead
// of add_.
void append_joint_answer(std::string& out, const plans::JointSnapshot& snapshot,
                         const plans::JointTarget& target, bool with_uncertainty);
void append_error_answer(std::string& out, const Error& error);
constexpr std::size_t kMaxTargetAnswer = 4096;

}  // namespace driftwise::formats
