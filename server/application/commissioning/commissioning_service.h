#pragma once

#include "server/application/commissioning/rest_desk.h"
#include "server/application/motion/workbench.h"
#include "server/application/plumbing/store_reader.h"

namespace driftwise::application {

class CommissioningService final : public Commissioning {
 public:
  // worker: for the mathematics. All of them outlive this.
  CommissioningService(Workbench& bench, StoreReader& reader, StoreWriter& writer,
                       const RunEngine& engine, RestDesk& rests, asio::any_io_executor worker);

  Awaitable<CellCheck> check(Caller caller) override;
  Awaitable<Result<ThermometerReport>> compare_thermometers(
      CellTime from, CellTime to, std::vector<std::string> channels) override;
  Awaitable<Result<void>> begin_rest(Caller caller, RestLimits limits) override;
  Awaitable<Result<void>> end_rest(Caller caller) override;
  Awaitable<Result<RestReport>> rest() override;
  std::vector<CertificateState> certificates() const override;

 private:
  Workbench& bench_;
  StoreReader& reader_;
  StoreWriter& writer_;
  const RunEngine& engine_;
  RestDesk& rests_;
  asio::any_io_executor worker_;
};

}  // namespace driftwise::application
