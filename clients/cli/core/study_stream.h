#pragma once
// A study at the daemon, which streams its progress and then its answer. Ctrl-C leaves the stream,
// and that ends the work.

#include <string>

#include "clients/cli/core/job_bar.h"
#include "clients/cli/core/session.h"

namespace driftwise::cli {

template <class Stub, class Request, class Response>
Response follow_study(const Session& session,
                      std::unique_ptr<grpc::ClientReader<Response>> (Stub::*method)(
                          grpc::ClientContext*, const Request&),
                      const std::type_identity_t<Request>& request, const std::string& what) {
  const auto connection = session.connect();
  Response answer;
  JobBar bar(session.console);
  connection.follow(method, request, [&](const Response& response) {
    if (response.has_progress())
      bar.show(what, response.progress().fraction(), response.progress().step());
    else
      answer = response;
    return true;
  });
  return answer;
}

}  // namespace driftwise::cli
