#include "clients/cli/commands/record/record_file.h"

#include "clients/cli/core/clean_message.h"
#include "clients/cli/core/value_or_throw.h"
#include "server/core/utc_map.h"
#include "storage/sqlite_store.h"

namespace driftwise::cli {
namespace {

std::unique_ptr<Store> open_record(const std::string& path) {
  return value_or_throw(storage::open_sqlite_store(path, true));
}

void set_head(v1::ChainHead& message, const ChainHead& head) {
  message.set_entry(head.entry);
  message.set_hash(head.hash);
}

UtcMap utc_of(Store& store) {
  std::vector<UtcStretch> stretches;
  for (const auto& clock : value_or_throw(store.clocks().clocks()))
    stretches.push_back({clock.from, clock.offset});
  return UtcMap(std::move(stretches));
}

}  // namespace

std::string head_text(const v1::ChainHead& head) {
  return to_string(ChainHead{head.entry(), head.hash()});
}

ChainHead kept_head(const std::string& text) {
  const auto head = chain_head_from(text);
  if (!head)
    throw Failure{ExitCode::usage, "usage", "BAD_CHAIN_HEAD",
                  "--head: found '" + text +
                      "', expected HASH@N as 'driftwise audit head' prints it: 64 hexadecimal "
                      "digits, @, the number of an entry"};
  return *head;
}

v1::RecordCopy copy_message(const RecordCopy& copy) {
  v1::RecordCopy message;
  message.set_path(copy.path);
  message.set_byte_count(copy.bytes);
  message.set_row_count(copy.rows);
  set_head(*message.mutable_head(), copy.head);
  return message;
}

v1::ListActsResponse acts_of_file(const std::string& path, const v1::ListActsRequest& request) {
  const auto store = open_record(path);
  const UtcMap utc = utc_of(*store);
  const int limit = request.limit() == 0 ? 100 : request.limit();
  v1::ListActsResponse response;
  for (const auto& act : value_or_throw(store->audit().acts(request.before_id(), limit))) {
    v1::Act& out = *response.add_acts();
    const std::int64_t ns = utc.utc(act.at.utc).ns;
    out.set_id(act.id);
    out.mutable_time()->set_seconds(ns / 1'000'000'000);
    out.mutable_time()->set_nanos(static_cast<std::int32_t>(ns % 1'000'000'000));
    out.set_who(act.by.name);
    out.set_proof(act.by.proof);
    out.set_from(act.by.from);
    out.set_what(act.what);
    out.set_subject(act.subject);
    out.set_before(act.before);
    out.set_after(act.after);
    out.set_outcome(act.outcome);
    out.set_event_id(act.event.value);
  }
  clean_message(response);
  return response;
}

v1::GetChainHeadResponse head_of_file(const std::string& path) {
  v1::GetChainHeadResponse response;
  set_head(*response.mutable_head(), value_or_throw(open_record(path)->audit().head()));
  return response;
}

v1::VerifyRecordResponse verified_file(const std::string& path,
                                       const v1::VerifyRecordRequest& request) {
  std::optional<ChainHead> kept;
  if (request.has_kept()) kept = ChainHead{request.kept().entry(), request.kept().hash()};
  const auto report = value_or_throw(open_record(path)->audit().verify(kept, {}));
  v1::VerifyRecordResponse response;
  set_head(*response.mutable_head(), report.head);
  response.set_unit_count(report.units);
  response.set_row_count(report.rows);
  response.set_difference_count(report.differences);
  response.set_thinned_reading_count(report.thinned_readings);
  for (const auto& sentence : report.thinned) response.add_thinned(sentence);
  for (const auto& sentence : report.first) response.add_differences(sentence);
  clean_message(response);
  return response;
}

}  // namespace driftwise::cli
