#pragma once
// End of what clients show: a controller whose token or certificate ends gets no target from that
// instant on. Tokens are known from their book, certificates from the first call that shows them.

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/access/role.h"

namespace driftwise::access {

struct ProofEnd {
  std::string subject;  // "token k3f9a2c1", "certificate of ada"
  std::string name;     // whose
  Role role = Role::viewer;
  std::int64_t begins_utc_s = 0, ends_utc_s = 0;
};

struct EndingProof {
  std::string subject, message;  // without a message: known, and its end is not to be spoken of
};
// Those to speak of: from 30 days before the end, of a short one from the last third of its time,
// until a week after it. Not where a later one of the same kind, name and role is there.
std::vector<EndingProof> ending(const std::vector<ProofEnd>& proofs, std::int64_t now_utc_s);

// Certificates that were shown and were good. Any thread.
class ShownCertificates {
 public:
  static constexpr std::size_t kMost = 1000;
  void note(const std::string& pem, const std::string& name, Role role);
  // End of a certificate's time, without reading it again where it was noted. Nothing: it is none.
  std::optional<std::int64_t> end_utc_s(const std::string& pem) const;
  std::vector<ProofEnd> all() const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, ProofEnd> shown_;  // by their text
};

}  // namespace driftwise::access
