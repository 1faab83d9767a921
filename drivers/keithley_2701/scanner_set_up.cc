// The scanner's set-up: after every new connection, and checked by what the scanner says about it.

#include <cstdio>
#include <utility>

#include "drivers/keithley_2701/scanner.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::keithley {
namespace {

constexpr int kMaxErrorReads = 12;  // the queue holds ten, and an overflow entry

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

}  // namespace

Awaitable<Result<void>> Scanner::set_up() {
  layout_.reset();
  selected_.reset();
  anchor_.forget();
  // A serial line keeps half a command of whoever was here before: break it off and end it.
  if (auto sent = co_await link_.tell("\x03" + options_.send_end, timeout_); !sent) co_return sent;
  DRIFTWISE_CO_TRY(const auto identity, co_await ask("*IDN?"));
  const std::string identity_text(transport::without_line_ends(identity));
  know_identity(identity_text, identity);
  if (identity_text.find("MODEL 27") == std::string::npos)
    co_return nonsense({ErrorCode::failed_precondition, reasons::kWrongDevice,
                        "expected a KEITHLEY MODEL 2700, 2701 or 2750"});

  // Before *CLS, which erases it. The queue of a new connection is not ours.
  errors_before_.clear();
  if (!is_new_connection()) {
    DRIFTWISE_CO_TRY(errors_before_, co_await read_errors());
  }
  std::vector<std::string> reset{"*RST", "*CLS"};
  if (auto done = co_await execute(std::move(reset)); !done) co_return done;

  DRIFTWISE_CO_TRY(const auto cards, co_await ask("*OPT?"));
  const std::string card_text(transport::without_line_ends(cards));
  if (options_.require_card && card_text.find("77") == std::string::npos)
    co_return link_.refused(
        reasons::kNoCard,
        "no scanner card in any slot: four-wire scanning needs one (7700, 7708, ...)");
  link_.set_identity(identity_text + " [" + card_text + "]");

  if (auto done = co_await configure(); !done) co_return done;
  for (std::size_t i = 0; i < lists_.size(); ++i) {
    if (auto done = co_await select(i); !done) co_return done;
    if (auto same = co_await compare_scan_list(lists_[i]); !same) co_return same;
  }
  if (auto clean = co_await check_errors(); !clean) co_return clean;
  co_return Result<void>{};
}

namespace {

// Function and parameters of each input of the list.
std::vector<std::string> functions_of(const ScanList& one) {
  const std::string list = encode_channel_list(one.inputs);
  const auto& options = one.options;
  if (one.function == ScanFunction::dc_volts)
    return {"FUNC 'VOLT'," + list, "VOLT:RANG " + number(options.range_v) + "," + list,
            "VOLT:NPLC " + number(options.nplc) + "," + list};
  return {"FUNC 'FRES'," + list,  // never RES: one ohm of lead is 0.26 K
          "FRES:RANG " + number(options.range_ohm) + "," + list,
          "FRES:OCOM " + std::string(options.offset_compensation ? "ON" : "OFF") + "," + list,
          "FRES:NPLC " + number(options.nplc) + "," + list};
}

}  // namespace

Awaitable<Result<void>> Scanner::configure() {
  std::vector<std::string> commands{
      "TRAC:CLE",
      "INIT:CONT OFF",  // with it on, SAMP:COUN above 1 is refused
      "FORM:ELEM READ,CHAN,TST",
      "TRIG:SOUR IMM",
      "TRIG:COUN 1",  // later scans would overwrite earlier ones
      "TRIG:DEL 0",
      "ROUT:SCAN:LSEL NONE",  // before the list may change
  };
  for (const auto& list : lists_) {
    auto more = functions_of(list);
    commands.insert(commands.end(), more.begin(), more.end());
  }
  co_return co_await execute(std::move(commands));
}

// On RS-232 the commands wait in a queue: some 400 bytes take 0.8 s at 4800 baud, and *RST, *CLS
// and the functions are slow. *OPC? after them (M 10-19) has the time that they need, so that the
// next query has its own.
Awaitable<Result<void>> Scanner::execute(std::vector<std::string> commands) {
  const std::string query = "*OPC?" + options_.send_end;
  std::size_t bytes = query.size();
  for (const auto& command : commands) {
    bytes += command.size() + options_.send_end.size();
    if (auto sent = co_await tell(command); !sent) co_return sent;
  }
  DRIFTWISE_CO_TRY(const auto complete,
                   co_await link_.ask(query, scan_timeout(lists_.front()) + transmission(bytes)));
  if (transport::without_line_ends(complete) != "1")
    co_return nonsense({ErrorCode::data_loss, reasons::kBadReply, "expected 1"});
  co_return Result<void>{};
}

// After FUNC, which may have shrunk the list silently.
Awaitable<Result<void>> Scanner::select(std::size_t number) {
  const ScanList& list = lists_[number];
  std::vector<std::string> commands;
  if (std::exchange(selected_, std::nullopt)) commands.emplace_back("ROUT:SCAN:LSEL NONE");
  commands.push_back("SAMP:COUN " + std::to_string(list.inputs.size()));
  commands.push_back("ROUT:SCAN " + encode_channel_list(list.inputs));
  commands.emplace_back("ROUT:SCAN:TSO IMM");
  commands.emplace_back("ROUT:SCAN:LSEL INT");
  if (auto done = co_await execute(std::move(commands)); !done) co_return done;
  selected_ = number;
  co_return Result<void>{};
}

Awaitable<Result<void>> Scanner::compare_scan_list(const ScanList& wanted) {
  DRIFTWISE_CO_TRY(const auto reply, co_await ask("ROUT:SCAN?"));
  const auto list = parse_channel_list(reply);
  if (!list) co_return nonsense(list.error());
  if (*list == wanted.inputs) co_return Result<void>{};
  co_return link_.refused(
      reasons::kScanList,
      "asked to scan " + encode_channel_list(wanted.inputs) + " for '" + wanted.device +
          "': an input is missing, or it is one of the pair of a four-wire channel "
          "(a 20-channel card scans 101..110 in four-wire)");
}

Awaitable<Result<std::string>> Scanner::read_errors() {
  std::string found;
  for (int i = 0; i < kMaxErrorReads; ++i) {
    DRIFTWISE_CO_TRY(const auto reply, co_await ask("SYST:ERR?"));
    const auto error = parse_device_error(reply);
    if (!error) co_return nonsense(error.error());
    if (error->number == 0) break;
    found += (found.empty() ? "" : "; ") + std::to_string(error->number) + " " + error->text;
  }
  co_return found;
}

Awaitable<Result<void>> Scanner::check_errors() {
  DRIFTWISE_CO_TRY(const auto found, co_await read_errors());
  if (found.empty()) co_return Result<void>{};
  co_return link_.refused(
      reasons::kSetUp,
      "the scanner refused a part of its set-up: " + found +
          (errors_before_.empty() ? "" : "; its error queue said before: " + errors_before_));
}

}  // namespace driftwise::keithley
