#include "server/kinematics/mechanism.h"

#include <set>
#include <string>

#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/kinematics/delta.h"
#include "server/kinematics/linear_axis.h"
#include "server/kinematics/serial_arm.h"

namespace driftwise::kinematics {
namespace {

template <class Kind>
Result<std::shared_ptr<const Mechanism>> shared(Result<Kind> made) {
  DRIFTWISE_RETURN_IF_ERROR(made);
  std::set<std::string> symbols;
  for (const auto* channels : {&made->inputs(), &made->outputs()})
    for (const auto& channel : *channels)
      if (!symbols.insert(channel.symbol).second)
        return fail(ErrorCode::invalid_argument, reasons::kBadKinematics,
                    "kinematics: found " + channel.name() + " twice, expected each once");
  return std::make_shared<const Kind>(std::move(*made));
}

}  // namespace

Result<std::shared_ptr<const Mechanism>> make_mechanism(const KinematicsDescription& description) {
  if (description.kind == "delta-vertical") return shared(Delta::create(description));
  if (description.kind == "serial-arm") return shared(SerialArm::create(description));
  if (description.kind == "linear-axis") return shared(Axis::create(description));
  return fail(ErrorCode::invalid_argument, reasons::kBadKinematics,
              "kinematics: found kind '" + description.kind +
                  "', expected delta-vertical, serial-arm or linear-axis");
}

}  // namespace driftwise::kinematics
