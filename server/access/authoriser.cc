#include "server/access/authoriser.h"

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "server/access/certificate.h"
#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"
#include "server/core/try.h"

namespace driftwise::access {
namespace {

constexpr const char* kLocalCredential = "local";  // shorter than the id of any token
constexpr std::size_t kMostNameBytes = 64, kMostSources = 1024, kMostBearerBytes = 512;
constexpr std::chrono::minutes kWindow{1};

std::string short_name(std::string_view name) { return clean_line(name.substr(0, kMostNameBytes)); }

std::int64_t utc_seconds() {
  return std::chrono::duration_cast<std::chrono::seconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

Authoriser::Authoriser(Parts parts) : parts_(std::move(parts)), secret_(random_bytes(32)) {
  if (!parts_.local_token.empty()) local_token_hash_ = sha256(parts_.local_token);
  if (!parts_.steady) parts_.steady = [] { return std::chrono::steady_clock::now(); };
  if (!parts_.utc_s) parts_.utc_s = utc_seconds;
}

void Authoriser::tell(AccessWitness* witness) {
  const std::lock_guard lock(mutex_);
  witness_ = witness;
}

void Authoriser::note(AccessNote what) {
  const std::lock_guard lock(mutex_);
  if (witness_ != nullptr) witness_->note(std::move(what));
}

// Somebody who tries for ever fills neither the record nor the memory.
void Authoriser::note_within_bounds(AccessNote what) {
  const auto now = parts_.steady();
  const std::lock_guard lock(mutex_);
  const std::string source = source_of(what.from);
  if (!told_.contains(source) && told_.size() >= kMostSources) told_.clear();
  Told& told = told_[source];
  if (now - told.since >= kWindow) {
    told.since = now;
    told.told = 0;
  }
  if (told.told >= kMostToldPerMinute) {
    ++told.silent;
    return;
  }
  ++told.told;
  what.count = 1 + std::exchange(told.silent, 0);
  if (what.count > 1)
    what.detail += " (and " + std::to_string(what.count - 1) + " more from there before)";
  if (witness_ != nullptr) witness_->note(std::move(what));
}

Identity Authoriser::local(const Evidence& evidence, Proof proof) const {
  std::string name = short_name(evidence.stated_name);
  if (name.empty()) name = proof == Proof::open_loopback ? "unknown" : parts_.local_user;
  return {std::move(name), Role::admin, proof, proof == Proof::token ? kLocalCredential : "",
          evidence.from};
}

Result<Identity> Authoriser::identify(const Evidence& evidence) {
  if (!evidence.bearer.empty()) return by_token(evidence);
  if (revoked(evidence.certificate_pem)) return certificate_over(evidence);
  std::optional<Role> role;
  for (const auto& uri : evidence.certificate_uris)
    if (const auto one = role_from_uri(uri); one && (!role || includes(*one, *role))) role = one;
  const std::string subject = short_name(evidence.certificate_name);
  if (role) {
    Identity who{subject.empty() ? "unnamed" : subject,
                 *role,
                 Proof::certificate,
                 "",
                 evidence.from,
                 evidence.certificate_pem};
    shown_.note(evidence.certificate_pem, who.name, who.role);
    if (!in_force(who)) return certificate_over(evidence);
    return who;
  }
  if (evidence.door == Door::unix_socket) return local(evidence, Proof::local_socket);
  if (evidence.door == Door::loopback && parts_.loopback == LoopbackRule::open)
    return local(evidence, Proof::open_loopback);
  return nobody(evidence);
}

bool Authoriser::in_force(const Identity& who) const {
  const auto now_utc_s = parts_.utc_s();
  if (!who.certificate_pem.empty()) {
    const auto end_utc_s = shown_.end_utc_s(who.certificate_pem);
    return end_utc_s && *end_utc_s > now_utc_s && !revoked(who.certificate_pem);
  }
  if (who.credential.empty() || who.credential == kLocalCredential) return true;
  return parts_.tokens != nullptr && parts_.tokens->in_force(who.credential, now_utc_s);
}

bool Authoriser::knows(std::string_view bearer) const {
  const std::string_view text = bearer.substr(0, kMostBearerBytes);
  if (!local_token_hash_.empty() && same_bytes(sha256(text), local_token_hash_)) return true;
  return parts_.tokens != nullptr && parts_.tokens->known(text, parts_.utc_s());
}

std::vector<EndingProof> Authoriser::ending() const {
  auto proofs = shown_.all();
  if (parts_.tokens != nullptr)
    for (const auto& token : parts_.tokens->list())
      if (token.expires_utc_s)
        proofs.push_back({"token " + token.id, token.name, token.role, token.created_utc_s,
                          *token.expires_utc_s});
  auto all = access::ending(proofs, parts_.utc_s());
  const std::vector<EndingProof> told = all;
  for (const auto& proof : proofs)
    if (std::ranges::find(told, proof.subject, &EndingProof::subject) == told.end())
      all.push_back({proof.subject, ""});
  return all;
}

tl::unexpected<Error> Authoriser::nobody(const Evidence& evidence) {
  Error error{ErrorCode::unauthenticated, reasons::kNoIdentity, ""};
  if (!evidence.certificate_name.empty() || !evidence.certificate_uris.empty()) {
    error.reason = reasons::kNoRole;
    error.message = "the certificate of '" + short_name(evidence.certificate_name) +
                    "' names no role: make one with 'driftwise cert client NAME --role ROLE', "
                    "which puts driftwise:role/ROLE into its subject alternative name";
  } else if (evidence.door == Door::loopback) {
    error.message =
        "this address of the daemon asks for a token: use the command line as the user who runs "
        "the daemon, give --token-file with driftwised.token of its state folder, or a token of "
        "'driftwise token create'";
  } else {
    error.message =
        "nobody has said who this is: give a client certificate (--tls-cert, --tls-key) or a "
        "token (--token-file)";
  }
  note_within_bounds({AccessNote::Kind::wrong_try, short_name(evidence.stated_name), evidence.from,
                      "a call without an identity: " + error.reason});
  return tl::unexpected(std::move(error));
}

tl::unexpected<Error> Authoriser::certificate_over(const Evidence& evidence) {
  const std::string name = short_name(evidence.certificate_name);
  const bool on_list = revoked(evidence.certificate_pem);
  std::string how = "was revoked";
  if (!on_list) {
    const auto end_utc_s = shown_.end_utc_s(evidence.certificate_pem);
    how = end_utc_s ? "has ended on " + day_of(*end_utc_s) : "cannot be read";
  }
  Error error{ErrorCode::unauthenticated,
              on_list ? reasons::kCertificateRevoked : reasons::kCertificateExpired,
              "the certificate of '" + name + "' " + how +
                  ": an admin makes another one ('driftwise cert client')"};
  note_within_bounds({AccessNote::Kind::wrong_try, name, evidence.from,
                      "a call with the certificate of '" + name + "', which " + how, 1,
                      "certificate"});
  return tl::unexpected(std::move(error));
}

Result<Identity> Authoriser::by_token(const Evidence& evidence) {
  const std::string_view text = std::string_view(evidence.bearer).substr(0, kMostBearerBytes);
  if (!local_token_hash_.empty() && same_bytes(sha256(text), local_token_hash_))
    return local(evidence, Proof::token);
  const std::string source = source_of(evidence.from);
  const auto now_utc_s = parts_.utc_s();
  auto record = parts_.tokens ? parts_.tokens->known(text, now_utc_s) : std::nullopt;
  if (!record) {
    std::chrono::milliseconds wait;
    {
      const std::lock_guard lock(mutex_);
      wait = tries_.must_wait(source, parts_.steady());
    }
    if (wait.count() > 0)
      return fail(ErrorCode::resource_exhausted, reasons::kTooManyTries,
                  "too many wrong tokens came from there: none is looked at for another " +
                      std::to_string((wait.count() + 999) / 1000) + " s");
    if (!parts_.tokens)
      return wrong_token(evidence, {ErrorCode::unauthenticated, reasons::kBadToken,
                                    "this daemon keeps no tokens ([access] of its cell file)"});
    auto checked = parts_.tokens->check(text, now_utc_s);
    if (!checked && checked.error().code != ErrorCode::unauthenticated)
      return tl::unexpected(checked.error());
    if (!checked) return wrong_token(evidence, checked.error());
    record = *checked;
    const std::lock_guard lock(mutex_);
    tries_.right(source);
  }
  return Identity{record->name, record->role, Proof::token, record->id, evidence.from};
}

tl::unexpected<Error> Authoriser::wrong_token(const Evidence& evidence, const Error& error) {
  WrongTries::Count count;
  {
    const std::lock_guard lock(mutex_);
    count = tries_.wrong(source_of(evidence.from), parts_.steady());
  }
  AccessNote what{AccessNote::Kind::wrong_try, short_name(evidence.stated_name), evidence.from,
                  "a wrong token, number " + std::to_string(count.tries) + " in a row"};
  if (count.pause.count() > 0) {
    what.kind = AccessNote::Kind::locked;
    what.detail += ": nothing from there is looked at for " +
                   std::to_string(count.pause.count() / 1000) + " s";
  }
  note_within_bounds(std::move(what));
  return tl::unexpected(error);
}

Result<void> Authoriser::authorise(const Identity& who, const Action& action) {
  if (includes(who.role, action.needed)) return {};
  const std::string message = sentence(who) + " may not " + std::string(action.name) +
                              ": it needs the role " + std::string(to_string(action.needed)) +
                              ", this is " + std::string(to_string(who.role));
  std::string proof(to_string(who.proof));
  if (!who.credential.empty()) proof += " " + who.credential;
  note_within_bounds({AccessNote::Kind::refused, who.name, who.from, message, 1, std::move(proof),
                      std::string(action.name)});
  return fail(ErrorCode::permission_denied, reasons::kNeedsRole, message);
}

std::string Authoriser::vouch(const Identity& who) const {
  const nlohmann::json json = {{"name", who.name},
                               {"role", static_cast<int>(who.role)},
                               {"proof", static_cast<int>(who.proof)},
                               {"credential", who.credential},
                               {"from", who.from}};
  return secret_ + json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::optional<Identity> Authoriser::vouched(std::string_view bytes) const {
  if (bytes.size() <= secret_.size() || !same_bytes(bytes.substr(0, secret_.size()), secret_))
    return std::nullopt;
  // Ours: nobody else knows the secret.
  const auto json = nlohmann::json::parse(bytes.substr(secret_.size()));
  return Identity{json.at("name"), static_cast<Role>(json.at("role").get<int>()),
                  static_cast<Proof>(json.at("proof").get<int>()), json.at("credential"),
                  json.at("from")};
}

}  // namespace driftwise::access
