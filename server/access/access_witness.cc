#include "server/access/access_witness.h"

namespace driftwise::access {

std::string to_event(AccessNote::Kind kind) {
  switch (kind) {
    case AccessNote::Kind::refused:
      return "access.refused";
    case AccessNote::Kind::wrong_try:
      return "access.wrong_try";
    case AccessNote::Kind::locked:
      return "access.locked";
    case AccessNote::Kind::token_made:
      return "access.token_made";
    case AccessNote::Kind::token_revoked:
      return "access.token_revoked";
  }
  return "access";
}

}  // namespace driftwise::access
