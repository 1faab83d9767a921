#pragma once
// The daemon as one object: composes the parts of a cell, starts them and shuts them down. What
// clients ask is answered by its services.
//
// Thread: the executor's (co_spawn onto it). Lifetime: start() once, then shut_down() once; the
// destructor expects the executor to have stopped.

#include <boost/asio/any_io_executor.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/access/access_witness.h"
#include "server/access/proof_ends.h"
#include "server/application/cell/services.h"
#include "server/application/diagnoses/diagnosis_progress.h"
#include "server/application/recording/devices.h"
#include "server/core/description/cell_description.h"
#include "server/core/ports/awaitable.h"
#include "server/core/ports/clock.h"
#include "server/core/ports/outside/notifier.h"
#include "server/core/ports/store.h"
#include "server/core/result.h"
#include "server/formats/text/kept_stop.h"

namespace driftwise::application {

class Composition;

class Cell {
 public:
  struct Parts {
    CellDescription description;
    Devices devices;
    std::unique_ptr<Clock> clock;
    OpenStore open_store;
    std::string version;
    // Executors of the writing store, the queries, the fits and the diagnoses: at most one thread
    // each at a time. Empty: threads of the cell's own. A test hands in its one executor and has
    // everything in order.
    asio::any_io_executor storage_thread = {}, query_thread = {}, worker_thread = {},
                          diagnosis_thread = {}, text_thread = {}, upkeep_thread = {},
                          notify_threads = {};
    std::unique_ptr<Notifier> notifier = {};  // the way out of the machine; none: nobody is told
    std::string boot_id = {};                 // of this start of the computer; empty: not known
    std::string web_address = {};  // "http://127.0.0.1:8080/", told in status(); empty: no web door
    std::string web_address_outside = {};   // in messages to receivers; empty: web_address
    Diagnose diagnose = {};                 // empty: diagnosis::diagnose
    std::function<void()> end_daemon = {};  // asks for shut_down(); empty: nobody does
    // A stop that a person asked for while no daemon answered: pending from the start on, stored
    // when open() is through.
    std::optional<formats::KeptStop> kept_stop = {};
    // The last lines of the log, oldest first; empty: none is kept.
    std::function<std::vector<std::string>()> log_tail = {};
    int schema_version = 0;            // of the database; 0: not told
    std::string report_template = {};  // path of report.html; empty: reports cannot be made
    bool measure_pauses = false;       // of the executor: by the wall clock, so not in virtual time
  };
  static Result<std::unique_ptr<Cell>> open(asio::any_io_executor executor, Parts parts);
  ~Cell();

  // Starts the recorder and, where a run was under way when the daemon ended, its continuation.
  void start();
  // Resumes when every device has been tried once, and the status says which are there.
  Awaitable<void> devices_looked_at();
  // Resumes when the promoted model or plan serves again after a start, or is refused.
  Awaitable<void> served_again();
  // First part of the end, while the doors are open: nothing begins to move, what moves is stopped,
  // long calls end. Resumes when every controller that moved has reported no motion in two
  // successive answers, or after 20 s of wall time. A stop is taken meanwhile, and until
  // shut_down().
  Awaitable<void> come_to_rest();
  Awaitable<void> shut_down();
  // After it. False: a computation has not ended, and this cannot be destroyed; the record is
  // closed.
  bool all_ended() const;
  // After it: who stopped the cell or paused the run, or the daemon itself for a run that is over,
  // where the database took nothing and the record does not say so: the next start would begin the
  // queue, or let the run go on. Whoever ends the daemon keeps it, as a stop that nobody answered.
  std::optional<formats::KeptStop> halt_not_on_record() const;

  const Services& services() const { return services_; }
  // What the doors tell of access becomes events and alarms. Any thread, until shut_down().
  access::AccessWitness& access_witness();
  // Tokens and certificates of clients that are about to end become alarms. Before start().
  void ask_for_ends(std::function<std::vector<access::EndingProof>()> ends);

 private:
  explicit Cell(std::unique_ptr<Composition> parts);

  std::unique_ptr<Composition> parts_;
  Services services_;
};

}  // namespace driftwise::application
