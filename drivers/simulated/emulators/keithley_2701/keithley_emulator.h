#pragma once
// A Keithley 2701 multimeter with scanner (PROTOCOLS section 1): SCPI over TCP (LF) or a serial
// line (CR, reply terminator as configured; request and reply take the time of their bytes).
// Messages are executed one after the other; a message that arrives while a query is still waiting
// for its measurement interrupts it (-410, the pending reply is lost), as the maker's "read the
// whole reply before the next message" says. 0x03 and 0x18 clear the device: measurement, replies
// and waiting messages are dropped.
//
// A scan takes its time in cell time: per channel the integrations, the relay and the trigger
// delay; a probe's resistance is taken at the end of its own integration, and so is its time stamp.

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drivers/simulated/emulators/emulator.h"
#include "drivers/simulated/emulators/keithley_2701/channel_list.h"
#include "drivers/simulated/emulators/keithley_2701/keithley_settings.h"
#include "drivers/simulated/emulators/keithley_2701/scpi.h"
#include "drivers/simulated/emulators/line_buffer.h"
#include "drivers/simulated/emulators/switches.h"
#include "drivers/simulated/emulators/timed_line.h"

namespace driftwise::simulated {

class KeithleyEmulator : public Emulator {
 public:
  static const std::vector<SwitchDescription>& switches();
  // Throws SetupError.
  KeithleyEmulator(PlantThermometers& plant, const Switches& switches, TimeNs power_on);

  void open(Session session, Link link, TimeNs now) override;
  void close(Session session, TimeNs now) override;
  void receive(Session session, std::string_view bytes, TimeNs now) override;

 private:
  struct Client {
    Link link;
    LineBuffer input;
    TimedLine request_line;
  };
  struct Message {
    Session session;
    std::string text;
  };
  struct Job {  // the message that is being executed
    Session session;
    std::vector<std::string> units;
    std::size_t next = 0;
    std::vector<std::string> path, replies;
    bool indefinite = false;  // a reply of arbitrary text stands last: no further query (-440)
    bool waiting_query = false;
  };
  struct Sample {
    double value;
    Function function;
    double stamp_s;
    long number;
    int channel;
  };
  enum Element : unsigned {
    kRead = 1,
    kUnit = 2,
    kStamp = 4,
    kNumber = 8,
    kChannel = 16,
    kLimit = 32
  };
  struct Trigger {
    std::string source = "IMM";
    int count = 1;  // 0: without end
    double delay_s = 0, timer_s = 0.1;
    bool delay_auto = true;
  };
  struct Run {  // an acquisition under way
    std::vector<int> channels;
    int sample = 0, scan = 0;
    TimeNs scan_start = 0;
    bool awaiting_trigger = false;
    std::optional<Timeline::EventId> event;
  };
  struct Targets {
    std::vector<ChannelSettings*> settings;
    std::vector<int> channels;  // empty: the front inputs
    int error = 0;
  };
  using Arguments = ScpiTree::Arguments;

  // keithley_emulator.cc: messages and jobs
  void take(Session session, std::string_view bytes, TimeNs now);
  void device_clear(Session session);
  void message(Session session, LineBuffer::Line line, TimeNs now);
  void start_next(TimeNs now);
  void run_job(TimeNs now);
  void take_answer(const ScpiAnswer& answer, bool query);
  void finish_job(TimeNs now);
  void resume(ScpiAnswer answer, TimeNs now);
  void reset(bool preset);

  // keithley_sense.cc, keithley_route.cc, keithley_trigger.cc, keithley_system.cc: the commands
  void add_sense_commands();
  void add_function_commands(const std::string& header, Function function);
  void add_temperature_commands();
  void add_route_commands();
  void add_trigger_commands();
  void add_buffer_commands();
  void add_system_commands();
  // The channels that the last argument names (taken off), or the front inputs.
  Targets targets(Arguments& arguments);
  // A number for each target: <number>|DEF|MIN|MAX[,list]; the query answers each with what get
  // says.
  template <class Get, class Put>
  void add_number(const std::string& header, std::optional<Function> function, double min,
                  double max, double fallback, Get get, Put put);
  template <class Get, class Put>
  void add_flag(const std::string& header, std::optional<Function> function, Get get, Put put);
  int conflict(const Targets& targets, std::optional<Function> function) const;
  void shrink_scan();

  // keithley_measure.cc
  ScpiAnswer initiate(TimeNs now);
  void abort();
  void next_sample(TimeNs now);
  void sampled(TimeNs now);
  void finished(TimeNs now);
  double measure(const ChannelSettings& settings, int channel, TimeNs now);
  double measured_volt(const ChannelSettings& settings, int channel, TimeNs now);
  std::string text_of(const Sample& sample) const;
  std::string text_of(const std::vector<Sample>& samples, std::size_t from,
                      std::size_t count) const;
  ChannelSettings& settings_of(int channel);

  PlantThermometers& plant_;
  const Cards cards_;
  const std::string identity_, reply_terminator_;
  const bool interrupts_, typed_order_, needs_function_, user_rtd_known_, channel_suffix_;
  const int pairing_error_;
  const double mains_hz_, relay_s_, reset_s_, lead_ohm_, baud_;
  const TimeNs latency_;
  const std::size_t message_limit_;

  ScpiTree tree_;
  ScpiErrorQueue errors_;
  std::map<Session, Client> clients_;
  std::deque<Message> waiting_;
  std::optional<Job> job_;
  std::optional<Timeline::EventId> job_event_;
  TimeNs now_ = 0;  // of the unit that is being executed

  ChannelSettings front_;
  std::map<int, ChannelSettings> channels_;
  std::vector<int> scan_list_;
  bool scanning_ = false;
  std::optional<int> closed_;
  Trigger trigger_;
  int samples_ = 1;
  bool continuous_ = false;
  unsigned elements_ = kRead | kUnit | kStamp | kNumber;
  char temperature_unit_ = 'C';
  TimeNs stamp_zero_ = 0;
  std::string stamp_type_ = "REL";
  unsigned event_status_ = 0, event_enable_ = 0, service_enable_ = 0;
  bool opc_pending_ = false;

  std::optional<Run> run_;
  enum class Pending { none, read, complete } pending_ = Pending::none;  // what the job waits for
  std::vector<Sample> readings_;
  std::vector<Sample> buffer_;
  int buffer_size_ = 100;
  bool buffer_fills_ = false;
};

}  // namespace driftwise::simulated
