#pragma once
// The client's side of the record of an indentation on the daemon.

#include <string>

#include "clients/cli/core/connection.h"
#include "clients/cli/core/session.h"
#include "driftwise/v1/indentation_service.pb.h"
#include "server/indentation/procedure.h"

namespace driftwise::cli {

class IndentReport {
 public:
  // Puts the indentation on record, or goes on with the one of its key, which it makes where there
  // is none. Throws Failure: the daemon's refusal; nothing was moved.
  IndentReport(const Connection& connection, const Console& console, const std::string& file_text,
               indentation::ProcedureRecord& record);

  // A report that is refused or lost does not end the procedure: it is said once.
  void report(const indentation::ProcedureRecord& record, const std::string& ended = {});
  std::int64_t id() const { return id_; }

 private:
  const Connection connection_;  // also after Ctrl-C
  const Console& console_;
  std::int64_t id_ = 0;
  bool is_lost_ = false;
};

// Number of the indentation of this key on the daemon. Throws Failure: none, unreachable.
std::int64_t indentation_of_key(const Connection& connection, const std::string& key);

void print_indentation_list(const Session& session);
// output: file for the record, for `indent start` on another computer; empty: none.
void print_stored_indentation(const Session& session, std::int64_t id, const std::string& output);

}  // namespace driftwise::cli
