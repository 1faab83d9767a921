// driftwised: puts the daemon together. The only place that names a concrete driver or store.
//
// Threads: main waits for signals; one executor thread owns the cell, its devices and its doors but
// gRPC's; gRPC has its own. Order of the end: the axes come to rest while every door still takes a
// stop, then gRPC (its calls need the executor), the other doors, the cell, the executor. Every
// start-up failure is a sentence on standard error and an exit code: 3 bad input, 5 refused.

#include <malloc.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <array>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_future.hpp>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "drivers/all_devices.h"
#include "server/access/access.h"
#include "server/application/cell/cell.h"
#include "server/application/manual/manual_control.h"
#include "server/application/plans/joint_targets.h"
#include "server/application/plumbing/store_refusal.h"
#include "server/application/serving/targets.h"
#include "server/application/status/overview.h"
#include "server/application/upkeep/cell_clock.h"
#include "server/clean_log.h"
#include "server/controller_claim.h"
#include "server/core/reasons.h"
#include "server/core/try.h"
#include "server/descriptor_limit.h"
#include "server/formats/cell_file/cell_file.h"
#include "server/formats/cell_file/startable_cell.h"
#include "server/heap_upkeep.h"
#include "server/kept_stop_file.h"
#include "server/line/target_line_server.h"
#include "server/notice_file.h"
#include "server/notify/outside_notifier.h"
#include "server/rpc/server/rpc_server.h"
#include "server/service_manager.h"
#include "server/start_warnings.h"
#include "server/web/http_server.h"
#include "server/web/web_site.h"
#include "storage/schema/schema.h"
#include "storage/sqlite_store.h"

namespace driftwise {
namespace {

namespace fs = std::filesystem;

// All three doors full, devices and database beside them.
constexpr std::size_t kFewDescriptors = 1024;

struct Arguments {
  std::string cell_file;
  std::string log_level = "info";
  std::string web_root;  // in place of [web] root
  bool check = false;
};

int exit_code_of(const Error& error) {
  const bool bad_input =
      error.code == ErrorCode::invalid_argument || error.code == ErrorCode::not_found;
  return bad_input ? 3 : 5;
}

Result<application::Devices> make_devices(const CellDescription& cell, const std::string& path,
                                          DeviceContext context) {
  context.shared = std::make_shared<SharedByAddress>();
  application::Devices devices;
  for (std::size_t i = 0; i < cell.devices.size(); ++i) {
    auto made = find_kind(cell.kinds, cell.devices[i].kind)->make(cell.devices[i], context);
    if (!made) {
      Error error = std::move(made.error());
      if (error.code == ErrorCode::invalid_argument)
        error.message.insert(0, formats::device_place(cell, path, i, error.message));
      return tl::unexpected(std::move(error));
    }
    DRIFTWISE_RETURN_IF_ERROR(claim_controller(cell.devices[i], context.claims.get()));
    devices.push_back(std::move(*made));
  }
  return devices;
}

// The executor's thread; work handed to it is waited for.
class ExecutorThread {
 public:
  explicit ExecutorThread(asio::io_context& context)
      : context_(context),
        work_(asio::make_work_guard(context)),
        thread_([&context] { context.run(); }) {}
  ~ExecutorThread() {
    context_.stop();
    thread_.join();
  }
  ExecutorThread(const ExecutorThread&) = delete;
  ExecutorThread& operator=(const ExecutorThread&) = delete;

  template <class Work>
  void run(Work work) {
    std::promise<void> done;
    asio::post(context_, [&] {
      work();
      done.set_value();
    });
    done.get_future().wait();
  }

 private:
  asio::io_context& context_;
  asio::executor_work_guard<asio::io_context::executor_type> work_;
  std::thread thread_;
};

// The cell with its doors; the web's stands on gRPC's. Destroyed in reverse.
struct Daemon {
  std::unique_ptr<KeptStopFile> kept_stop;
  std::unique_ptr<access::Access> access;
  std::unique_ptr<application::Cell> cell;
  // By the key of driftwised.json that names them: "target_line", "target_line_tls", ...
  std::map<std::string, std::unique_ptr<line::TargetLineServer>> lines;
  std::unique_ptr<rpc::RpcServer> rpc;
  std::unique_ptr<web::HttpServer> http, https;
};

tls::TlsFiles tls_files(const AccessDescription& access) {
  return {access.certificate, access.key, access.authority};
}

// The page's address for who is elsewhere: by its first name; a door of all addresses without a
// name by the computer's.
std::string page_address_outside(const AccessDescription& access, const web::HttpServer& door) {
  std::array<char, 256> host{};
  std::string name = access.names.empty() ? "" : access.names.front();
  const bool of_all = access.http.starts_with("0.0.0.0:") || access.http.starts_with("[::]:");
  if (name.empty() && of_all && ::gethostname(host.data(), host.size() - 1) == 0)
    name = host.data();
  if (name.empty()) return door.origin() + "/";
  return "https://" + name + ":" + std::to_string(door.port()) + "/";
}

Result<void> open_line(Daemon& daemon, const std::string& key, line::LineDoor door,
                       const Clock& clock, asio::io_context& context) {
  if (door.address.empty()) return {};
  DRIFTWISE_TRY(daemon.lines[key],
                line::TargetLineServer::start(
                    {context.get_executor(), daemon.cell->services().host.background(),
                     daemon.cell->services().targets.snapshots(), clock, *daemon.access,
                     &daemon.cell->services().joint_targets.board()},
                    std::move(door)));
  return {};
}

Result<void> open_lines(Daemon& daemon, const CellDescription& description, const Clock& clock,
                        asio::io_context& context) {
  const AccessDescription& access = description.access;
  DRIFTWISE_RETURN_IF_ERROR(
      open_line(daemon, "target_line", {description.target_line}, clock, context));
  DRIFTWISE_RETURN_IF_ERROR(open_line(daemon, "target_line_plain",
                                      {access.plain_target_line, line::LineKind::plain_network,
                                       nullptr, access.plain_interface, access.plain_allow},
                                      clock, context));
  if (access.target_line.empty()) return {};
  DRIFTWISE_TRY(auto material,
                tls::TlsMaterial::open(tls_files(access), tls::ClientCertificate::accepted));
  return open_line(daemon, "target_line_tls",
                   {access.target_line, line::LineKind::tls, std::move(material)}, clock, context);
}

// Template of the reports, beside the page.
std::string report_template(const std::string& web_root) {
  const auto root = web::find_web_root(web_root);
  return root.empty() ? std::string() : (root / "report.html").string();
}

// The page at one of its doors.
void serve_page(web::HttpServer& http, Daemon& daemon, const std::string& web_root, bool secure) {
  http.serve(web::make_web_site({daemon.cell->services().host, daemon.cell->services().overview,
                                 daemon.rpc->in_process_channel(), web::find_web_root(web_root),
                                 http.executor(), *daemon.access, secure, http.port()}));
}

Result<void> open_doors(Daemon& daemon, const CellDescription& description,
                        const std::string& web_root, const Clock& clock,
                        asio::io_context& context) {
  DRIFTWISE_RETURN_IF_ERROR(open_lines(daemon, description, clock, context));
  DRIFTWISE_TRY(auto rpc, rpc::RpcServer::open(daemon.cell->services(), description.listen, {},
                                               daemon.access.get()));
  daemon.rpc = std::move(rpc);
  if (daemon.http) serve_page(*daemon.http, daemon, web_root, false);
  if (daemon.https) serve_page(*daemon.https, daemon, web_root, true);
  return {};
}

// Empty: the page that came with the program.
Result<void> check_web_page(const std::string& web_root) {
  std::error_code ignored;
  if (web_root.empty() || fs::is_regular_file(fs::path(web_root) / "index.html", ignored))
    return {};
  return fail(ErrorCode::not_found, reasons::kNoWebPage,
              "[web] root: found no index.html in " + web_root +
                  ", expected the folder of the web page (leave the key out for the one that came "
                  "with the program)");
}

// Whether the record can be opened or made at its path, as far as this user may write there.
Result<void> check_database_folder(const std::string& database) {
  const std::string folder = fs::absolute(database).parent_path().string();
  if (::access(folder.c_str(), R_OK | W_OK | X_OK) == 0) return {};
  return fail(ErrorCode::invalid_argument, reasons::kCannotOpen,
              "[cell] database: found " + database + ", and of its folder " + folder + ": " +
                  std::strerror(errno) + "; expected a folder that this user may write to");
}

// Of this start of the computer, by the kernel; empty where it tells none. Source: random(4).
std::string boot_id() {
  std::string id;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> id;
  return id;
}

Result<Daemon> put_together(CellDescription description, asio::io_context& context,
                            const Arguments& arguments) {
  // A check starts nothing, so it does not ask for the clock that a simulated cell would share.
  const ClockDescription wanted = arguments.check ? ClockDescription{} : description.clock;
  DRIFTWISE_TRY(auto clock, application::CellClock::open(context.get_executor(), wanted));
  Clock& the_clock = *clock;
  // A check drives nothing, so it may be made beside the daemon of the same cell.
  const auto claims = arguments.check ? nullptr : std::make_shared<locks::Claims>();
  DRIFTWISE_TRY(auto devices, make_devices(description, arguments.cell_file,
                                           {context.get_executor(), the_clock, claims}));
  const std::string web_root = arguments.web_root.empty()
                                   ? formats::web_root_of(description, arguments.cell_file)
                                   : arguments.web_root;
  if (auto page = check_web_page(web_root); !page) {
    if (arguments.check) return tl::unexpected(page.error());
    spdlog::warn("{}", page.error().message);  // no reason not to measure
  }
  warn_of_secrets(description.receivers, description.watchdog);
  if (arguments.check) {
    DRIFTWISE_RETURN_IF_ERROR(check_database_folder(description.database));
    DRIFTWISE_RETURN_IF_ERROR(access::Access::check(description.access));
    warn_of_certificate(description.access);
    return Daemon{};
  }

  Daemon daemon;
  std::string web_address, web_address_outside;
  if (!description.http.empty()) {  // listens first: the cell tells where
    DRIFTWISE_TRY(auto http, web::HttpServer::open(description.http));
    daemon.http = std::move(http);
    web_address = daemon.http->origin() + "/";
  }
  if (!description.access.http.empty()) {
    DRIFTWISE_TRY(auto material,
                  tls::TlsMaterial::open(tls_files(description.access),
                                         tls::ClientCertificate::ignored, "http/1.1"));
    DRIFTWISE_TRY(daemon.https,
                  web::HttpServer::open(description.access.http, std::move(material)));
    if (web_address.empty()) web_address = daemon.https->origin() + "/";
    web_address_outside = page_address_outside(description.access, *daemon.https);
  }
  daemon.kept_stop = std::make_unique<KeptStopFile>(kept_stop_of_cell(arguments.cell_file));
  // Looked at here alone: a record that is restored beside a daemon is not the one it works on.
  KeptStopFile of_record(formats::kept_stop_of_record(description.database));
  const auto stop_of_cell = daemon.kept_stop->read(), stop_of_record = of_record.read();
  const OpenStore open_store = [](const std::string& path, bool read_only) {
    return storage::open_sqlite_store(path, read_only);
  };
  auto notifier = std::make_unique<notify::OutsideNotifier>();
  DRIFTWISE_TRY(auto cell,
                application::Cell::open(context.get_executor(),
                                        {.description = description,
                                         .devices = std::move(devices),
                                         .clock = std::move(clock),
                                         .open_store = open_store,
                                         .version = DRIFTWISE_VERSION,
                                         .notifier = std::move(notifier),
                                         .boot_id = boot_id(),
                                         .web_address = web_address,
                                         .web_address_outside = web_address_outside,
                                         .end_daemon = [] { ::kill(::getpid(), SIGTERM); },
                                         .kept_stop = stop_of_cell ? stop_of_cell : stop_of_record,
                                         .log_tail = log_tail,
                                         .schema_version = storage::schema_version(),
                                         .report_template = report_template(web_root),
                                         .measure_pauses = true}));
  daemon.cell = std::move(cell);
  if (stop_of_cell) daemon.kept_stop->remove();
  if (stop_of_record) of_record.remove();
  // The database is ours by now, and so are the files beside it.
  DRIFTWISE_TRY(auto access,
                access::Access::open(description.access,
                                     fs::path(description.database).parent_path().string()));
  daemon.access = std::move(access);
  daemon.access->authoriser().tell(&daemon.cell->access_witness());
  daemon.cell->ask_for_ends(
      [&authoriser = daemon.access->authoriser()] { return authoriser.ending(); });
  DRIFTWISE_RETURN_IF_ERROR(open_doors(daemon, description, web_root, the_clock, context));
  return daemon;
}

nlohmann::ordered_json notice_of(const Daemon& daemon) {
  nlohmann::ordered_json notice = {{"grpc", daemon.rpc->address()}};
  if (!daemon.rpc->socket_path().empty()) notice["socket"] = daemon.rpc->socket_path();
  if (!daemon.access->token_file().empty()) notice["token_file"] = daemon.access->token_file();
  if (!daemon.rpc->tls_address().empty()) notice["grpc_tls"] = daemon.rpc->tls_address();
  for (const auto& [key, line] : daemon.lines) notice[key] = line->address();
  if (daemon.http) {
    notice["http"] = daemon.http->address();
    notice["web"] = daemon.http->origin() + "/";
  }
  if (daemon.https) notice["web_tls"] = daemon.https->origin() + "/";
  notice["pid"] = getpid();
  return notice;
}

void serve_until_signal(Daemon& daemon, asio::io_context& context, const Arguments& arguments,
                        const sigset_t& signals) {
  ExecutorThread executor(context);
  executor.run([&] { daemon.cell->start(); });
  // Whoever hears that the daemon is ready shall see which devices are there; one that does not
  // answer does not keep it from being ready.
  asio::co_spawn(context, daemon.cell->devices_looked_at(), asio::use_future)
      .wait_for(std::chrono::seconds(1));
  // A controller that comes back after a restart shall not hear that no model serves.
  asio::co_spawn(context, daemon.cell->served_again(), asio::use_future)
      .wait_for(std::chrono::seconds(20));
  {
    const auto content = notice_of(daemon);
    const NoticeFile notice(arguments.cell_file, content.dump(2) + '\n');
    daemon.rpc->ready(true);
    const ServiceManager service_manager(context.get_executor());
    const KeptStopWatch kept_stops(*daemon.kept_stop, [&](const formats::KeptStop& kept) {
      spdlog::warn("stopped by {}, as {} said since {}", kept.who, formats::kKeptStopFile,
                   kept.asked);
      asio::co_spawn(
          context, daemon.cell->services().manual.stop_all({kept.who, formats::kKeptStopFile, {}}),
          asio::use_future)
          .wait();
    });
    const HeapUpkeep heap([&host = daemon.cell->services().host] { return host.now(); });
    spdlog::info("{} is ready: {}", daemon.cell->services().overview.description().name,
                 content.dump());
    int signal = 0;
    sigwait(&signals, &signal);
    spdlog::info("{}: shutting down", strsignal(signal));
    pthread_sigmask(SIG_UNBLOCK, &signals,
                    nullptr);  // a second signal ends it at once: the record survives that
    // Nobody is left without a stop while something moves.
    asio::co_spawn(context, daemon.cell->come_to_rest(), asio::use_future)
        .wait_for(std::chrono::seconds(30));
  }
  daemon.http.reset();
  daemon.https.reset();
  const bool calls_ended = daemon.rpc->shut_down(std::chrono::seconds(2));
  if (!calls_ended) spdlog::warn("a call has not ended: its answer is not waited for");
  executor.run([&] {
    for (auto& [key, line] : daemon.lines) line->stop();
  });
  daemon.access->authoriser().tell(nullptr);
  asio::co_spawn(context, daemon.cell->shut_down(), asio::use_future).wait();
  if (const auto halt = daemon.cell->halt_not_on_record()) daemon.kept_stop->keep(*halt);
  if (daemon.cell->all_ended() && daemon.rpc->shut_down(std::chrono::seconds(1))) return;
  // What the computation would find nobody is left to store; its thread refers to what would go.
  spdlog::warn("a computation has not ended; the record is closed and the daemon ends without it");
  spdlog::shutdown();
  std::_Exit(0);
}

// The same as put_together() of a context of its own; where the record takes nothing for now (a
// full disk, a program that holds it) it waits and tries again, for whoever restarts daemons would
// give this one up. Errors: its others; cancelled: a signal came meanwhile.
Result<Daemon> put_together_when_storable(const CellDescription& description,
                                          std::optional<asio::io_context>& context,
                                          const Arguments& arguments, const sigset_t& signals) {
  constexpr timespec kTryAgain{10, 0};
  std::string told;
  for (;;) {
    context.emplace(1);  // nothing refers to one whose start failed
    auto daemon = put_together(description, *context, arguments);
    if (daemon || arguments.check || !application::may_be_stored_later(daemon.error()))
      return daemon;
    if (told != daemon.error().message) {
      told = daemon.error().message;
      spdlog::error(
          "cannot start yet: {} ({}); nothing is measured or served meanwhile. The daemon waits "
          "and "
          "tries again every {} s, by itself",
          told, daemon.error().reason, kTryAgain.tv_sec);
      tell_service_manager_of_wait("waits to start: " + told);
    }
    if (const int signal = sigtimedwait(&signals, nullptr, &kTryAgain); signal > 0) {
      spdlog::info("{}: ends before it could start", strsignal(signal));
      return fail(ErrorCode::cancelled, reasons::kShuttingDown, "ended before it could start");
    }
  }
}

int run(const Arguments& arguments) {
  auto description = formats::read_cell_file(arguments.cell_file, drivers::all_devices());
  if (description)
    if (const auto good = formats::check_startable(*description, arguments.cell_file); !good)
      description = tl::unexpected(good.error());
  const auto complain = [](const Error& error) {
    std::cerr << "driftwised: " << error.message << " (" << error.reason << ")\n";
    return exit_code_of(error);
  };
  if (!description) {
    complain(description.error());
    return 3;  // whatever is wrong with it: who restarts daemons shall leave this one
  }
  const std::string name = description->name;
  const std::size_t devices = description->devices.size();

  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals,
                  nullptr);  // before any thread: all of them leave signals to main
  std::signal(SIGPIPE, SIG_IGN);

  if (const auto descriptors = raise_descriptor_limit(); descriptors < kFewDescriptors)
    spdlog::warn(
        "this process may open {} files and sockets, {} are needed when all doors are "
        "busy: raise the limit (LimitNOFILE, ulimit -n)",
        descriptors, kFewDescriptors);
  std::optional<asio::io_context> context;
  auto daemon = put_together_when_storable(*description, context, arguments, signals);
  if (!daemon) return daemon.error().code == ErrorCode::cancelled ? 0 : complain(daemon.error());
  if (arguments.check) {
    std::cout << arguments.cell_file << ": good: cell '" << name << "' with " << devices
              << " devices\n";
    return 0;
  }
  serve_until_signal(*daemon, *context, arguments, signals);
  daemon->rpc.reset();
  return 0;
}

}  // namespace
}  // namespace driftwise

int main(int argc, char** argv) {
  mallopt(M_ARENA_MAX,
          2);  // one arena per thread would cost gRPC's threads 64 MiB of address space each
  driftwise::Arguments arguments;
  CLI::App app(
      "Examples:\n  driftwised --cell cell.toml\n  driftwised --cell cell.toml --check\n\n"
      "driftwised: the daemon of a Driftwise cell",
      "driftwised");
  app.set_version_flag("--version", DRIFTWISE_VERSION);
  app.add_option("--cell", arguments.cell_file, "the cell's description (docs/cell-file.md)")
      ->required();
  app.add_flag("--check", arguments.check,
               "read the cell file, say what is wrong with it, start nothing");
  app.add_option("--web-root", arguments.web_root,
                 "folder of the web page, in place of [web] root in the cell file");
  app.add_option("--log-level", arguments.log_level, "trace, debug, info, warning, error or off")
      ->check(CLI::IsMember({"trace", "debug", "info", "warning", "error", "off"}))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    app.exit(error);
    return error.get_exit_code() == 0 ? 0 : 2;
  }
  driftwise::set_up_log(arguments.log_level);
  try {
    return driftwise::run(arguments);
  } catch (const std::exception& failed) {
    std::cerr << "driftwised: cannot start: " << failed.what() << '\n';
    return 5;
  }
}
