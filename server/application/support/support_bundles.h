#pragma once
// Everything that a person who helps needs, in one archive. Executor's thread.

#include <string>

#include "server/application/ports/caller.h"
#include "server/core/ports/awaitable.h"
#include "server/core/result.h"

namespace driftwise::application {

class SupportBundles {
 public:
  static constexpr std::size_t kMostBytes = 16U << 20U;

  virtual ~SupportBundles() = default;
  // .tar.gz. No token, password or private key is in it. Errors: those of the store.
  virtual Awaitable<Result<std::string>> make(Caller caller) = 0;
};

}  // namespace driftwise::application
