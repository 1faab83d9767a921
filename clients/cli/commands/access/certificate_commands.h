#pragma once
// driftwise cert init | client | revoke: an authority of the site's own, by openssl(1). A site that
// has an authority uses that instead.

#include <CLI/App.hpp>

#include "clients/cli/core/session.h"

namespace driftwise::cli {

void add_certificate_commands(CLI::App& app, Session& session);

}  // namespace driftwise::cli
