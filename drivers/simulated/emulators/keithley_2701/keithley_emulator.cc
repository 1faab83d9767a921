#include "drivers/simulated/emulators/keithley_2701/keithley_emulator.h"

#include <algorithm>

#include "drivers/simulated/emulators/emulator_kind.h"
#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {
namespace {

constexpr std::size_t kScpiWaitingLimit = 64;
constexpr unsigned kPowerOn = 0x80, kCommandError = 0x20, kExecutionError = 0x10,
                   kDeviceError = 0x08, kQueryError = 0x04;

unsigned event_bit(int code) {
  if (code > 0 || (code <= -300 && code > -400)) return kDeviceError;
  if (code <= -400) return kQueryError;
  return code <= -200 ? kExecutionError : kCommandError;
}

}  // namespace

const std::vector<SwitchDescription>& KeithleyEmulator::switches() {
  static const std::vector<SwitchDescription> kAll{
      {"identity", "KEITHLEY INSTRUMENTS INC.,MODEL 2701,1192345,A12 /A02 ", "M",
       "answer to *IDN?"},
      {"slot1", "7700", "M", "card in slot 1: 7700 (20 channels) or 7708 (40) or NONE"},
      {"slot2", "NONE", "M", "card in slot 2"},
      {"mains_hz", "50", "M", "mains frequency: what one NPLC lasts"},
      {"relay_s", "0.03", "U", "time of a relay per scanned channel"},
      {"reset_s", "0.2", "U", "how long *RST, *CLS and SYST:PRES keep the device busy"},
      {"latency_s", "0.005", "own", "from the end of a query to its reply"},
      {"interrupt", "true", "U",
       "a message during a waiting query interrupts it (-410); false: it waits its turn"},
      {"scan_order", "ascending", "U",
       "order of readings on the wire: ascending or typed (as in ROUT:SCAN)"},
      {"parameter_needs_function", "true", "U",
       "RANG, NPLC .. with a channel list give -221 unless the channel has that function"},
      {"pairing_error", "-221", "U",
       "error of a four-wire function on a channel of the upper half"},
      {"user_rtd", "true", "U", "TEMP:FRTD:RZER, ALPH, BETA, DELT exist; false: -113"},
      {"channel_suffix", "false", "U", "with UNIT on, a channel reads 101INTCHAN; false: 101"},
      {"error_queue", "10", "M", "places of the error queue; one more gives -350"},
      {"lead_ohm", "1.0", "own", "resistance of the leads, which a two-wire function adds"},
      {"message_limit", "2048", "U", "bytes of a message; more give -363"},
      {"serial", "false", "own", "also serve a pseudo-terminal (printed in READY): RS-232, CR"},
      {"serial_terminator", "\\r", "D", "end of a reply on RS-232: \\r or \\r\\n or \\n or \\n\\r"},
      {"serial_baud", "19200", "M",
       "RS-232 requests and replies take 10 bits per byte; 0: no time"},
      {"max_clients", "1", "U", "TCP connections at a time; one more is closed at once"},
  };
  return kAll;
}

KeithleyEmulator::KeithleyEmulator(PlantThermometers& plant, const Switches& s, TimeNs power_on)
    : plant_(plant),
      cards_(upper(s.text("slot1")), upper(s.text("slot2"))),
      identity_(s.text("identity")),
      reply_terminator_(s.escaped_text("serial_terminator")),
      interrupts_(s.flag("interrupt")),
      typed_order_(s.choice("scan_order", {"ascending", "typed"}) == "typed"),
      needs_function_(s.flag("parameter_needs_function")),
      user_rtd_known_(s.flag("user_rtd")),
      channel_suffix_(s.flag("channel_suffix")),
      pairing_error_(s.integer("pairing_error", -999, 999)),
      mains_hz_(s.number("mains_hz", 1, 1000)),
      relay_s_(s.number("relay_s", 0, 10)),
      reset_s_(s.number("reset_s", 0, 60)),
      lead_ohm_(s.number("lead_ohm", 0, 1000)),
      baud_(s.number("serial_baud", 0, 1e6)),
      latency_(nanoseconds_from(s.number("latency_s", 0, 10))),
      message_limit_(static_cast<std::size_t>(s.integer("message_limit", 16, 65536))),
      errors_(static_cast<std::size_t>(s.integer("error_queue", 1, 1000))),
      stamp_zero_(power_on) {
  add_sense_commands();
  add_route_commands();
  add_trigger_commands();
  add_buffer_commands();
  add_system_commands();
  reset(true);  // a 2700 wakes up in its preset, measuring continuously
  event_status_ = kPowerOn;
}

void KeithleyEmulator::open(Session session, Link link, TimeNs) {
  const char terminator = link == Link::serial ? '\r' : '\n';
  clients_.insert_or_assign(session,
                            Client{link, LineBuffer(terminator, message_limit_), TimedLine(link)});
}

void KeithleyEmulator::close(Session session, TimeNs now) {
  const auto found = clients_.find(session);
  if (found == clients_.end()) return;
  if (found->second.input.unfinished().find('?') != std::string::npos) errors_.push(-420);
  clients_.erase(found);
  std::erase_if(waiting_, [session](const Message& one) { return one.session == session; });
  if (job_ && job_->session == session && job_->waiting_query) {
    if (pending_ == Pending::read) abort();
    pending_ = Pending::none;
    job_.reset();
    start_next(now);
  }
}

// A byte on RS-232 takes its time to come. Cut behind each byte that does something.
void KeithleyEmulator::receive(Session session, std::string_view bytes, TimeNs now) {
  const auto found = clients_.find(session);
  if (found == clients_.end()) return;
  if (found->second.link != Link::serial || baud_ <= 0) {
    take(session, bytes, now);
    return;
  }
  while (!bytes.empty()) {
    const auto length = std::min(bytes.find_first_of("\r\x03\x18"), bytes.size() - 1) + 1;
    const TimeNs due = found->second.request_line.carry(length, baud_, now);
    timeline_.at(due, [this, session, piece = std::string(bytes.substr(0, length))](TimeNs at) {
      take(session, piece, at);
    });
    bytes.remove_prefix(length);
  }
}

void KeithleyEmulator::take(Session session, std::string_view bytes, TimeNs now) {
  for (const char c : bytes) {
    const auto found = clients_.find(session);
    if (found == clients_.end()) return;
    if (c == 0x03 || c == 0x18) {
      device_clear(session);
    } else if (auto line = found->second.input.push(c)) {
      message(session, std::move(*line), now);
    }
  }
}

void KeithleyEmulator::device_clear(Session session) {
  abort();
  pending_ = Pending::none;
  if (job_event_) timeline_.cancel(*job_event_);
  job_event_.reset();
  job_.reset();
  waiting_.clear();
  clients_.at(session).input.clear();
}

void KeithleyEmulator::message(Session session, LineBuffer::Line line, TimeNs now) {
  std::erase_if(line.text, [](char c) { return c == '\r' || c == '\n'; });
  if (line.overrun || waiting_.size() >= kScpiWaitingLimit) {
    errors_.push(-363);
    return;
  }
  if (trim(line.text).empty()) return;
  waiting_.push_back({session, std::move(line.text)});
  if (job_ && job_->waiting_query && job_->session == session && interrupts_) {
    errors_.push(-410);
    event_status_ |= kQueryError;
    if (pending_ == Pending::read) abort();
    pending_ = Pending::none;
    job_.reset();
  }
  start_next(now);
}

void KeithleyEmulator::start_next(TimeNs now) {
  if (job_ || waiting_.empty()) return;
  Message next = std::move(waiting_.front());
  waiting_.pop_front();
  job_ = Job{.session = next.session, .units = split_units(next.text), .path = {}, .replies = {}};
  run_job(now);
}

void KeithleyEmulator::run_job(TimeNs now) {
  now_ = now;
  while (job_->next < job_->units.size()) {
    const ScpiParse parsed = parse_unit(job_->units[job_->next++]);
    if (!parsed.unit) {
      if (parsed.error != 0) take_answer(scpi_error(parsed.error), false);
      continue;
    }
    const bool query = parsed.unit->query;
    if (query && job_->indefinite) {
      take_answer(scpi_error(-440), false);
      continue;
    }
    const ScpiAnswer answer = tree_.call(*parsed.unit, job_->path);
    if (parsed.unit->nodes.front() == "*IDN" && query) job_->indefinite = true;
    if (answer.wait) {
      job_->waiting_query = query;
      return;
    }
    take_answer(answer, query);
    if (answer.busy_s > 0) {
      job_event_ = timeline_.at(now + nanoseconds_from(answer.busy_s), [this](TimeNs due) {
        job_event_.reset();
        run_job(due);
      });
      return;
    }
  }
  finish_job(now);
}

void KeithleyEmulator::take_answer(const ScpiAnswer& answer, bool query) {
  if (answer.error != 0) {
    errors_.push(answer.error);
    event_status_ |= event_bit(answer.error);
  } else if (query) {
    job_->replies.push_back(answer.text.value_or(""));
  }
}

void KeithleyEmulator::resume(ScpiAnswer answer, TimeNs now) {
  pending_ = Pending::none;
  if (!job_) return;
  take_answer(answer, job_->waiting_query);
  job_->waiting_query = false;
  run_job(now);
}

void KeithleyEmulator::finish_job(TimeNs now) {
  const Job done = std::move(*job_);
  job_.reset();
  const auto client = clients_.find(done.session);
  if (!done.replies.empty() && client != clients_.end()) {
    std::string text;
    for (std::size_t i = 0; i < done.replies.size(); ++i)
      text += (i == 0 ? "" : ";") + done.replies[i];
    const bool serial = client->second.link == Link::serial;
    text += serial ? reply_terminator_ : "\n";
    const TimeNs out = TimedLine(client->second.link).carry(text.size(), baud_, now + latency_);
    job_ = Job{
        .session = done.session, .units = {}, .path = {}, .replies = {}};  // busy until it is out
    job_event_ =
        timeline_.at(out, [this, session = done.session, bytes = std::move(text)](TimeNs due) {
          job_event_.reset();
          job_.reset();
          if (clients_.contains(session)) send(session, bytes, due);
          start_next(due);
        });
    return;
  }
  start_next(now);
}

namespace emulator_kind {

extern const EmulatorKind keithley_2701;
const EmulatorKind keithley_2701{.kind = "keithley-2701",
                                 .section = "scanner",
                                 .quantity = Quantity::probe,
                                 .switches = KeithleyEmulator::switches,
                                 .serial_switch = "serial",
                                 .make = [](Plant& plant, const Switches& switches, PlantPlaces&,
                                            TimeNs now) -> std::unique_ptr<Emulator> {
                                   return std::make_unique<KeithleyEmulator>(plant, switches, now);
                                 },
                                 .is_shared_by_address = true};

}  // namespace emulator_kind

}  // namespace driftwise::simulated
