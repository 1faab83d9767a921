#pragma once

#include <functional>
#include <vector>

#include "server/application/motion/workbench.h"
#include "server/application/plumbing/store_reader.h"
#include "server/application/status/overview.h"
#include "server/application/support/support_bundles.h"

namespace driftwise::application {

class SupportService final : public SupportBundles {
 public:
  struct Program {
    int schema_version = 0;  // 0: not known
    // The last lines of the log, oldest first; empty: none is kept.
    std::function<std::vector<std::string>()> log_tail;
  };
  // background: for texts. All of them outlive this.
  SupportService(Program program, Workbench& bench, StoreReader& reader, const Overview& overview,
                 asio::any_io_executor background);
  Awaitable<Result<std::string>> make(Caller caller) override;

 private:
  std::string versions() const;
  std::string devices() const;
  std::string state() const;

  Program program_;
  Workbench& bench_;
  StoreReader& reader_;
  const Overview& overview_;
  asio::any_io_executor background_;
};

}  // namespace driftwise::application
