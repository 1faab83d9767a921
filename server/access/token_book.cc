#include "server/access/token_book.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "server/access/private_file.h"
#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"
#include "server/core/try.h"

namespace driftwise::access {
namespace {

using Json = nlohmann::ordered_json;
constexpr std::size_t kMostNameBytes = 64;

tl::unexpected<Error> not_good() {
  return fail(ErrorCode::unauthenticated, reasons::kBadToken,
              "the token is not good: it is unknown, revoked or expired; ask an admin for one "
              "(driftwise token create)");
}

std::string from_hex(const std::string& text) {
  const auto digit = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  std::string out;
  for (std::size_t at = 0; at + 1 < text.size(); at += 2)
    out += static_cast<char>(digit(text[at]) * 16 + digit(text[at + 1]));
  return out;
}

bool over(const TokenRecord& record, std::int64_t now_utc_s) {
  return record.expires_utc_s && *record.expires_utc_s <= now_utc_s;
}

}  // namespace

Result<std::unique_ptr<TokenBook>> TokenBook::open(const std::string& path, ScryptCost cost) {
  std::unique_ptr<TokenBook> book(new TokenBook(path, cost));
  DRIFTWISE_RETURN_IF_ERROR(book->read());
  return book;
}

Result<void> TokenBook::read() {
  DRIFTWISE_TRY(const auto text, read_private_file(path_));
  if (!text) return {};
  try {
    const auto json = Json::parse(*text);
    for (const auto& one : json.at("tokens")) {
      const auto role = role_from(one.at("role").get<std::string>());
      if (!role) throw std::runtime_error("role " + one.at("role").dump());
      Kept kept{{one.at("id"), one.at("name"), *role, one.at("created_utc_s"), {}, {}},
                from_hex(one.at("salt")),
                from_hex(one.at("scrypt")),
                {one.at("n"), one.at("r"), one.at("p")}};
      if (one.contains("expires_utc_s"))
        kept.record.expires_utc_s = one.at("expires_utc_s").get<std::int64_t>();
      kept.record.made_by = one.value("made_by", "");
      tokens_.push_back(std::move(kept));
    }
  } catch (const std::exception& wrong) {
    return fail(ErrorCode::data_loss, reasons::kBadTokens,
                path_ + " is no list of tokens (" + wrong.what() +
                    "): bring it back from a backup, or remove it and make new tokens");
  }
  return {};
}

Result<void> TokenBook::write(const std::vector<Kept>& tokens) const {
  Json all = {{"driftwise_tokens", 1}, {"tokens", Json::array()}};
  for (const auto& kept : tokens) {
    Json one = {{"id", kept.record.id},
                {"name", kept.record.name},
                {"role", to_string(kept.record.role)},
                {"created_utc_s", kept.record.created_utc_s},
                {"made_by", kept.record.made_by},
                {"n", kept.cost.n},
                {"r", kept.cost.r},
                {"p", kept.cost.p},
                {"salt", digest::hex_from(kept.salt)},
                {"scrypt", digest::hex_from(kept.hash)}};
    if (kept.record.expires_utc_s) one["expires_utc_s"] = *kept.record.expires_utc_s;
    all["tokens"].push_back(std::move(one));
  }
  return write_private_file(path_, all.dump(1) + "\n");
}

Result<FreshToken> TokenBook::create(const std::string& name, Role role, const std::string& made_by,
                                     std::int64_t now_utc_s,
                                     std::optional<std::int64_t> expires_utc_s) {
  if (name.empty() || name.size() > kMostNameBytes || clean_line(name) != name)
    return fail(ErrorCode::invalid_argument, reasons::kBadName,
                "name: expected 1 to 64 bytes of printable text, for example the program that "
                "shall use the token");
  if (expires_utc_s && *expires_utc_s <= now_utc_s)
    return fail(ErrorCode::invalid_argument, reasons::kBadTime,
                "expire_time: it is in the past; expected a time to come");
  if (expires_utc_s && *expires_utc_s - now_utc_s > kLongest_s)
    return fail(ErrorCode::invalid_argument, reasons::kBadTime,
                "expire_time: it is more than a hundred years ahead; give an earlier one, or none "
                "for a token that does not end");
  const TokenParts parts = new_token();
  Kept fresh{
      {parts.id, name, role, now_utc_s, expires_utc_s, made_by}, random_bytes(16), {}, cost_};
  {
    const std::lock_guard hashing(hashing_);
    DRIFTWISE_TRY(auto hash, scrypt_of(parts.secret, fresh.salt, cost_));
    fresh.hash = std::move(hash);
  }
  const std::lock_guard writing(writing_);
  auto tokens = all();
  if (tokens.size() >= kMostTokens)
    return fail(ErrorCode::resource_exhausted, reasons::kTooManyTokens,
                "there are " + std::to_string(kMostTokens) +
                    " tokens, no more are kept: revoke those that nobody uses");
  tokens.push_back(fresh);
  DRIFTWISE_RETURN_IF_ERROR(write(tokens));
  const std::lock_guard lock(mutex_);
  tokens_ = std::move(tokens);
  return FreshToken{fresh.record, token_text(parts)};
}

std::vector<TokenRecord> TokenBook::list() const {
  const std::lock_guard lock(mutex_);
  std::vector<TokenRecord> out;
  for (const auto& kept : tokens_) out.push_back(kept.record);
  return out;
}

Result<TokenRecord> TokenBook::revoke(const std::string& id) {
  const std::lock_guard writing(writing_);
  auto tokens = all();
  const auto found =
      std::ranges::find_if(tokens, [&](const Kept& kept) { return kept.record.id == id; });
  if (found == tokens.end())
    return fail(ErrorCode::not_found, reasons::kNoToken,
                "there is no token '" + clean_line(id.substr(0, 64)) +
                    "': 'driftwise token list' shows those there are");
  const Kept gone = *found;
  tokens.erase(found);
  DRIFTWISE_RETURN_IF_ERROR(write(tokens));  // what the file says is what is so
  const std::lock_guard lock(mutex_);
  tokens_ = std::move(tokens);
  std::erase_if(known_, [&](const auto& one) { return one.second == id; });
  return gone.record;
}

std::vector<TokenBook::Kept> TokenBook::all() const {
  const std::lock_guard lock(mutex_);
  return tokens_;
}

bool TokenBook::in_force(std::string_view id, std::int64_t now_utc_s) const {
  const std::lock_guard lock(mutex_);
  return std::ranges::any_of(tokens_, [&](const Kept& kept) {
    return kept.record.id == id && !over(kept.record, now_utc_s);
  });
}

std::optional<TokenRecord> TokenBook::known(std::string_view text, std::int64_t now_utc_s) const {
  const std::string hash = sha256(text);
  const std::lock_guard lock(mutex_);
  const auto found = known_.find(hash);
  if (found == known_.end()) return std::nullopt;
  for (const auto& kept : tokens_)
    if (kept.record.id == found->second && !over(kept.record, now_utc_s)) return kept.record;
  return std::nullopt;
}

Result<TokenRecord> TokenBook::check(std::string_view text, std::int64_t now_utc_s) {
  if (auto good = known(text, now_utc_s)) return *good;
  const auto parts = token_parts(text);
  // Of a token that is not there the same work is done, so that the time tells nothing.
  Kept kept{{}, std::string(16, '\0'), std::string(32, '\0'), cost_};
  bool there = false;
  if (parts) {
    const std::lock_guard lock(mutex_);
    for (const auto& one : tokens_)
      if (one.record.id == parts->id) {
        kept = one;
        there = true;
      }
  }
  std::string hash;
  {
    const std::lock_guard hashing(hashing_);
    DRIFTWISE_TRY(auto made, scrypt_of(parts ? parts->secret : "", kept.salt, kept.cost));
    hash = std::move(made);
  }
  if (!same_bytes(hash, kept.hash) || !there || over(kept.record, now_utc_s)) return not_good();
  const std::lock_guard lock(mutex_);
  // It may have been revoked meanwhile.
  if (std::ranges::none_of(tokens_,
                           [&](const Kept& one) { return one.record.id == kept.record.id; }))
    return not_good();
  known_[sha256(text)] = kept.record.id;
  return kept.record;
}

}  // namespace driftwise::access
