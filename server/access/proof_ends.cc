#include "server/access/proof_ends.h"

#include <algorithm>

#include "server/access/certificate.h"

namespace driftwise::access {
namespace {

constexpr std::int64_t kDay = 86'400, kForgotten_s = 7 * kDay;

// "token", "certificate"
std::string kind_of(const ProofEnd& proof) {
  return proof.subject.substr(0, proof.subject.find(' '));
}

bool takes_over(const ProofEnd& later, const ProofEnd& proof) {
  return later.ends_utc_s > proof.ends_utc_s && later.name == proof.name &&
         later.role == proof.role && kind_of(later) == kind_of(proof);
}

std::string sentence(const ProofEnd& proof, std::int64_t left_s) {
  const bool token = kind_of(proof) == "token";
  const std::string role(to_string(proof.role));
  std::string text =
      "the " + proof.subject + (token ? " of " + proof.name : "") + " (" + role + ") ";
  if (left_s <= 0)
    text += "has ended on " + day_of(proof.ends_utc_s) + ": calls with it are refused";
  else
    text += "ends on " + day_of(proof.ends_utc_s) + ", in " +
            (left_s < 2 * kDay ? std::to_string(left_s / 3600) + " h"
                               : std::to_string(left_s / kDay) + " days") +
            ": from then on calls with it are refused";
  const std::string make = token ? "driftwise token create " : "driftwise cert client ";
  return text + ". Make another one (" + make + proof.name + " --role " + role +
         ") and put it in its place";
}

}  // namespace

std::vector<EndingProof> ending(const std::vector<ProofEnd>& proofs, std::int64_t now_utc_s) {
  std::vector<EndingProof> out;
  for (const auto& proof : proofs) {
    const std::int64_t left_s = proof.ends_utc_s - now_utc_s;
    const std::int64_t ahead_s =
        std::min(kExpiryWarningDays * kDay, (proof.ends_utc_s - proof.begins_utc_s) / 3);
    if (left_s > ahead_s || left_s < -kForgotten_s) continue;
    const auto later = [&](const ProofEnd& other) { return takes_over(other, proof); };
    if (std::any_of(proofs.begin(), proofs.end(), later)) continue;
    out.push_back({proof.subject, sentence(proof, left_s)});
  }
  return out;
}

void ShownCertificates::note(const std::string& pem, const std::string& name, Role role) {
  const std::lock_guard lock(mutex_);
  if (pem.empty() || shown_.contains(pem)) return;
  const auto facts = certificate_from(pem);
  if (!facts) return;
  if (shown_.size() >= kMost) shown_.clear();
  shown_[pem] = {"certificate of " + name, name, role, facts->not_before_utc_s,
                 facts->not_after_utc_s};
}

std::optional<std::int64_t> ShownCertificates::end_utc_s(const std::string& pem) const {
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = shown_.find(pem); found != shown_.end()) return found->second.ends_utc_s;
  }
  const auto facts = certificate_from(pem);
  if (!facts) return std::nullopt;
  return facts->not_after_utc_s;
}

std::vector<ProofEnd> ShownCertificates::all() const {
  const std::lock_guard lock(mutex_);
  std::vector<ProofEnd> out;
  for (const auto& [pem, proof] : shown_) out.push_back(proof);
  return out;
}

}  // namespace driftwise::access
