#pragma once
// Access of one daemon, put together at its start: certificate and key checked, tokens read, the
// local token written. Made and destroyed on one thread; its parts are for any.
//
// In the state folder (the database's), all of mode 0600: "tokens.json" (token_book.h),
// "driftwised.token" (made at each start: a program that may read it is admin; removed at the end)
// and "driftwised.sock" (made by the gRPC door).

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "server/access/authoriser.h"
#include "server/access/certificate.h"
#include "server/access/page_links.h"
#include "server/access/token_book.h"
#include "server/core/description/access_description.h"

namespace driftwise::access {

class Access {
 public:
  // Writes nothing where [access] is not configured. A certificate whose time is over or has not
  // come is no error: the cell is measured and recorded on, and an alarm says it. Errors: those of
  // check_files, RevokedCertificates::open and TokenBook::open; unavailable CANNOT_WRITE.
  // utc_s: for tests; empty: the computer's clock.
  static Result<std::unique_ptr<Access>> open(const AccessDescription& description,
                                              const std::string& state_folder,
                                              std::function<std::int64_t()> utc_s = {});
  // The same without writing anything: for a look at the cell file.
  static Result<void> check(const AccessDescription& description);
  ~Access();
  Access(const Access&) = delete;
  Access& operator=(const Access&) = delete;

  const AccessDescription& description() const { return description_; }
  Authoriser& authoriser() { return *authoriser_; }
  TokenBook& tokens() { return *tokens_; }
  PageLinks& links() { return links_; }
  const std::string& token_file() const { return token_file_; }    // empty: none was written
  const std::string& socket_path() const { return socket_path_; }  // where the unix socket belongs

 private:
  Access() = default;

  AccessDescription description_;
  std::string token_file_, socket_path_;
  PageLinks links_;
  std::unique_ptr<TokenBook> tokens_;
  std::unique_ptr<RevokedCertificates> revoked_;
  std::unique_ptr<Authoriser> authoriser_;
};

}  // namespace driftwise::access
