#pragma once
// The cell's threads and its time, as callers see them.

#include <boost/asio/any_io_executor.hpp>

#include "server/core/cell_time.h"
#include "server/core/ports/awaitable.h"
#include "server/core/utc_map.h"

namespace driftwise::application {

class Host {
 public:
  virtual ~Host() = default;

  // The thread of every service: co_spawn onto it.
  virtual asio::any_io_executor executor() const = 0;
  // A second thread for what takes longer than a moment: texts that are read or written, figures.
  // Nothing there may touch a service.
  virtual asio::any_io_executor background() const = 0;
  // Cell time, and UTC of an instant of it and back. Any thread.
  virtual CellTime now() const = 0;
  virtual UtcTime utc(CellTime instant) const = 0;
  virtual CellTime cell_time(UtcTime utc) const = 0;
};

}  // namespace driftwise::application
