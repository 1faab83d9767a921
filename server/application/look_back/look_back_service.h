#pragma once

#include "server/application/datasets/datasets.h"
#include "server/application/look_back/look_back.h"
#include "server/application/models/models.h"
#include "server/application/motion/workbench.h"
#include "server/application/plumbing/store_reader.h"

namespace driftwise::application {

class LookBackService final : public LookBack {
 public:
  // worker: for the mathematics. All of them outlive this.
  LookBackService(Workbench& bench, StoreReader& reader, Datasets& datasets, Models& models,
                  asio::any_io_executor worker);

  Awaitable<Result<Stability>> stability_of(std::string channel, CellTime from,
                                            CellTime to) override;
  Awaitable<Result<std::vector<ComparedRun>>> compare(std::vector<RunId> runs,
                                                      std::optional<ModelId> model) override;
  Awaitable<Result<TimeNoteRecord>> add_note(Caller caller, TimeNoteRecord note) override;

 private:
  std::string device_of(const std::string& channel) const;  // empty: none gives it
  // t05 -> t05_degC, of the cell's channels; else as it is.
  std::string with_unit(std::string channel) const;

  Workbench& bench_;
  StoreReader& reader_;
  Datasets& datasets_;
  Models& models_;
  asio::any_io_executor worker_;
};

}  // namespace driftwise::application
