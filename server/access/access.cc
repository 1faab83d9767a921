#include "server/access/access.h"

#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>

#include "server/access/private_file.h"
#include "server/core/try.h"

namespace driftwise::access {
namespace {

std::string user_name() {
  const passwd* user = ::getpwuid(::geteuid());
  return user != nullptr ? user->pw_name : std::to_string(::geteuid());
}

}  // namespace

Result<void> Access::check(const AccessDescription& description) {
  if (!description.tls()) return {};
  DRIFTWISE_RETURN_IF_ERROR(check_files(description.certificate, description.key));
  if (!description.authority.empty())
    DRIFTWISE_RETURN_IF_ERROR(read_certificate(description.authority));
  if (!description.revoked.empty())
    DRIFTWISE_RETURN_IF_ERROR(
        RevokedCertificates::open(description.revoked, description.authority));
  return {};
}

Result<std::unique_ptr<Access>> Access::open(const AccessDescription& description,
                                             const std::string& state_folder,
                                             std::function<std::int64_t()> utc_s) {
  std::unique_ptr<Access> out(new Access);
  out->description_ = description;
  const std::filesystem::path folder(state_folder);
  Authoriser::Parts parts;
  parts.loopback = description.loopback;
  parts.local_user = user_name();
  parts.utc_s = std::move(utc_s);
  out->socket_path_ = (folder / "driftwised.sock").string();
  DRIFTWISE_RETURN_IF_ERROR(check(description));
  DRIFTWISE_TRY(auto tokens, TokenBook::open((folder / "tokens.json").string()));
  out->tokens_ = std::move(tokens);
  parts.tokens = out->tokens_.get();
  if (!description.revoked.empty()) {
    DRIFTWISE_TRY(out->revoked_,
                  RevokedCertificates::open(description.revoked, description.authority));
    parts.revoked = out->revoked_.get();
  }
  if (description.configured) {
    parts.local_token = token_text(new_token());
    out->token_file_ = (folder / "driftwised.token").string();
    DRIFTWISE_RETURN_IF_ERROR(write_private_file(out->token_file_, parts.local_token + "\n"));
  }
  out->authoriser_ = std::make_unique<Authoriser>(std::move(parts));
  return out;
}

Access::~Access() {
  if (!token_file_.empty()) std::remove(token_file_.c_str());
}

}  // namespace driftwise::access
