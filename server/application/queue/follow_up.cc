#include "server/application/queue/follow_up.h"

#include <fmt/format.h>

#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"
#include "server/core/text/shown_text.h"
#include "server/core/try.h"
#include "server/formats/formula/formula_tree.h"

namespace driftwise::application {

Result<FollowUp> parse_follow_up(std::string_view text) {
  const auto colon = text.find(':');
  const auto verb = text.substr(0, colon);
  FollowUp out;
  if (colon != std::string_view::npos) out.formula = std::string(text.substr(colon + 1));
  if (verb == "fit") {
    out.kind = FollowUp::Kind::fit;
  } else if (verb == "diagnose") {
    out.kind = FollowUp::Kind::diagnose;
  } else if (text == "notify" || text == "report") {
    if (text == "report") out.kind = FollowUp::Kind::report;
    return out;
  } else {
    return fail(ErrorCode::invalid_argument, reasons::kBadFollowUp,
                fmt::format("follow-up: found {}, expected 'fit:FORMULA', 'diagnose', "
                            "'diagnose:FORMULA', 'report' or 'notify'",
                            shown(text)));
  }
  const bool needs_formula = out.kind == FollowUp::Kind::fit || colon != std::string_view::npos;
  if (needs_formula && (out.formula.empty() || clean_line(out.formula) != out.formula))
    return fail(ErrorCode::invalid_argument, reasons::kBadFollowUp,
                fmt::format("follow-up: found {} without a formula of one line, expected "
                            "'{}:q ~ x'",
                            shown(text), verb));
  if (!out.formula.empty()) DRIFTWISE_RETURN_IF_ERROR(formats::parse_formula_text(out.formula, {}));
  return out;
}

}  // namespace driftwise::application
