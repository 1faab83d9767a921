#include <chrono>

#include "driftwise/v1/access_service.grpc.pb.h"
#include "server/access/authoriser.h"
#include "server/access/page_links.h"
#include "server/access/token_book.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/rpc/shared/caller.h"
#include "server/rpc/shared/convert_values.h"
#include "server/rpc/shared/services.h"
#include "server/rpc/shared/unary.h"

namespace driftwise::rpc {
namespace {

using Context = grpc::CallbackServerContext;
using Reactor = grpc::ServerUnaryReactor;

std::int64_t utc_now_s() {
  return std::chrono::duration_cast<std::chrono::seconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

v1::Token token_from(const access::TokenRecord& record) {
  v1::Token out;
  out.set_id(record.id);
  out.set_name(utf8_from(record.name));
  out.set_role(static_cast<v1::Role>(record.role));
  out.mutable_create_time()->set_seconds(record.created_utc_s);
  if (record.expires_utc_s) out.mutable_expire_time()->set_seconds(*record.expires_utc_s);
  out.set_created_by(utf8_from(record.made_by));
  return out;
}

// Tokens end by UTC, whatever cell time is: no Host is asked.
class AccessService final : public v1::AccessService::CallbackService {
 public:
  AccessService(access::Authoriser& authoriser, access::TokenBook* tokens, access::PageLinks* links)
      : authoriser_(authoriser), tokens_(tokens), links_(links) {}

  Reactor* GetIdentity(Context* context, const v1::GetIdentityRequest*,
                       v1::GetIdentityResponse* response) override {
    const auto& who = identity_of(*context);
    auto& out = *response->mutable_identity();
    out.set_name(utf8_from(who.name));
    out.set_role(static_cast<v1::Role>(who.role));
    out.set_proof(std::string(to_string(who.proof)));
    out.set_credential(utf8_from(who.credential));
    out.set_from(utf8_from(who.from));
    return answer_now(context, Result<void>{});
  }

  Reactor* CreateToken(Context* context, const v1::CreateTokenRequest* request,
                       v1::CreateTokenResponse* response) override {
    return answer_now(context, create(*context, *request, *response));
  }

  Reactor* ListTokens(Context* context, const v1::ListTokensRequest*,
                      v1::ListTokensResponse* response) override {
    if (tokens_)
      for (const auto& record : tokens_->list()) *response->add_tokens() = token_from(record);
    return answer_now(context, Result<void>{});
  }

  Reactor* RevokeToken(Context* context, const v1::RevokeTokenRequest* request,
                       v1::RevokeTokenResponse* response) override {
    return answer_now(context, revoke(*context, *request, *response));
  }

  Reactor* CreatePageLink(Context* context, const v1::CreatePageLinkRequest*,
                          v1::CreatePageLinkResponse* response) override {
    if (!links_)
      return answer_now(context, fail(ErrorCode::failed_precondition, reasons::kNoWebPage,
                                      "this daemon was started without a page"));
    const auto& who = identity_of(*context);
    // Else a session makes its own successor, and session_h ends nothing.
    if (who.proof == access::Proof::page_session)
      return answer_now(context, fail(ErrorCode::permission_denied, reasons::kPageSession,
                                      "a page session makes no further link: use `driftwise open` "
                                      "or log in with a token"));
    response->set_link(links_->make(who, std::chrono::steady_clock::now()));
    return answer_now(context, Result<void>{});
  }

 private:
  Result<access::TokenBook*> book() const {
    if (tokens_) return tokens_;
    return fail(ErrorCode::failed_precondition, reasons::kNoToken,
                "this daemon keeps no tokens: it was started without a state folder");
  }

  Result<void> create(const Context& context, const v1::CreateTokenRequest& request,
                      v1::CreateTokenResponse& response) {
    DRIFTWISE_TRY(auto* tokens, book());
    if (request.role() < v1::ROLE_VIEWER || request.role() > v1::ROLE_ADMIN)
      return fail(ErrorCode::invalid_argument, reasons::kBadRole,
                  "role: expected viewer, controller, operator, engineer or admin");
    std::optional<std::int64_t> expires_utc_s;
    if (request.has_expire_time()) expires_utc_s = request.expire_time().seconds();
    DRIFTWISE_TRY(const auto fresh,
                  tokens->create(request.name(), static_cast<access::Role>(request.role()),
                                 identity_of(context).name, utc_now_s(), expires_utc_s));
    tell(context, access::AccessNote::Kind::token_made, fresh.record, "made");
    *response.mutable_token() = token_from(fresh.record);
    response.set_text(fresh.text);
    return {};
  }

  Result<void> revoke(const Context& context, const v1::RevokeTokenRequest& request,
                      v1::RevokeTokenResponse& response) {
    DRIFTWISE_TRY(auto* tokens, book());
    DRIFTWISE_TRY(const auto gone, tokens->revoke(request.id()));
    tell(context, access::AccessNote::Kind::token_revoked, gone, "revoked");
    *response.mutable_token() = token_from(gone);
    return {};
  }

  void tell(const Context& context, access::AccessNote::Kind kind,
            const access::TokenRecord& record, const char* what) {
    const auto caller = caller_of(context);
    authoriser_.note({kind, caller.name, caller.peer,
                      "token " + record.id + " of " + record.name + ", " +
                          std::string(to_string(record.role)) + ", was " + what,
                      1, caller.proof});
  }

  access::Authoriser& authoriser_;
  access::TokenBook* tokens_;
  access::PageLinks* links_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_access_service(access::Authoriser& authoriser,
                                                   access::TokenBook* tokens,
                                                   access::PageLinks* links) {
  return std::make_unique<AccessService>(authoriser, tokens, links);
}

}  // namespace driftwise::rpc
