#include "server/line/line_rights.h"

#include <utility>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::line {
namespace {

constexpr std::chrono::seconds kLookAgain{1};

// "ipv4:192.168.7.10:5020" -> "192.168.7.10"
std::string host_of(const std::string& from) {
  const auto begin = from.find(':') + 1;
  return from.substr(begin, from.rfind(':') - begin);
}

}  // namespace

LineRights::LineRights(access::Access& access, LineKind kind, std::string from)
    : access_(access), kind_(kind), from_(std::move(from)) {
  if (kind == LineKind::loopback && access.description().loopback == LoopbackRule::open)
    identity_ = {"unknown", access::Role::admin, access::Proof::open_loopback, "", from_};
  if (kind == LineKind::plain_network)
    identity_ = {host_of(from_), access::Role::controller, access::Proof::address, "", from_};
}

Result<void> LineRights::take(const std::optional<tls::PeerCertificate>& certificate) {
  if (kind_ != LineKind::tls || !certificate) return {};
  access::Evidence evidence;
  evidence.from = from_;
  evidence.certificate_name = certificate->name;
  evidence.certificate_uris = certificate->uris;
  evidence.certificate_pem = certificate->pem;
  DRIFTWISE_TRY(auto who, access_.authoriser().identify(evidence));
  take(std::move(who));
  return {};
}

void LineRights::take(access::Identity who) {
  checked_ = {};  // it may have been revoked since it was identified: the first question looks
  identity_ = std::move(who);
}

access::Evidence LineRights::evidence_of(const std::string& token) const {
  access::Evidence evidence;
  evidence.door = kind_ == LineKind::tls ? access::Door::tls : access::Door::loopback;
  evidence.from = from_;
  evidence.bearer = token;
  return evidence;
}

Result<void> LineRights::may_ask() {
  const auto now = std::chrono::steady_clock::now();
  if (identity_ && now - checked_ >= kLookAgain) {
    checked_ = now;
    if (!access_.authoriser().in_force(*identity_)) identity_.reset();
  }
  if (!identity_)
    return fail(
        ErrorCode::unauthenticated, reasons::kNoIdentity,
        "nobody has said who this is: send TOKEN and a token first" +
            std::string(kind_ == LineKind::tls ? ", or connect with a client certificate" : ""));
  return access_.authoriser().authorise(*identity_, {"ask for targets", access::Role::controller});
}

}  // namespace driftwise::line
