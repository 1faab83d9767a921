#include "clients/cli/core/connection.h"

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "clients/cli/core/session.h"
#include "driftwise/v1/error_detail.pb.h"
#include "server/core/text/utf8.h"
#include "server/core/utc_map.h"
#include "server/formats/text/kept_stop.h"
#include "server/tls/own_certificate.h"

namespace driftwise::cli {
namespace {

const char* code_text(grpc::StatusCode code) {
  switch (code) {
    case grpc::StatusCode::CANCELLED:
      return "cancelled";
    case grpc::StatusCode::INVALID_ARGUMENT:
      return "invalid_argument";
    case grpc::StatusCode::DEADLINE_EXCEEDED:
      return "deadline_exceeded";
    case grpc::StatusCode::NOT_FOUND:
      return "not_found";
    case grpc::StatusCode::ALREADY_EXISTS:
      return "already_exists";
    case grpc::StatusCode::PERMISSION_DENIED:
      return "permission_denied";
    case grpc::StatusCode::UNAUTHENTICATED:
      return "unauthenticated";
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
      return "resource_exhausted";
    case grpc::StatusCode::FAILED_PRECONDITION:
      return "failed_precondition";
    case grpc::StatusCode::ABORTED:
      return "aborted";
    case grpc::StatusCode::OUT_OF_RANGE:
      return "out_of_range";
    case grpc::StatusCode::UNIMPLEMENTED:
      return "unimplemented";
    case grpc::StatusCode::UNAVAILABLE:
      return "unavailable";
    case grpc::StatusCode::DATA_LOSS:
      return "data_loss";
    default:
      return "internal";
  }
}

v1::ErrorDetail detail_of(const grpc::Status& status) {
  v1::ErrorDetail detail;
  v1::ErrorStatus packed;
  if (packed.ParseFromString(status.error_details()))
    for (const auto& any : packed.details()) any.UnpackTo(&detail);
  return detail;
}

using google::protobuf::FieldDescriptor;

// "text", "pose[2].channel": the first field whose bytes are no text.
std::string field_without_text(const google::protobuf::Message& message) {
  const auto& reflection = *message.GetReflection();
  std::vector<const FieldDescriptor*> set;
  reflection.ListFields(message, &set);
  for (const FieldDescriptor* field : set) {
    const bool text = field->type() == FieldDescriptor::TYPE_STRING;
    if (!text && field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      const bool repeated = field->is_repeated();
      const std::string name = field->name() + (repeated ? "[" + std::to_string(i) + "]" : "");
      std::string scratch;
      if (text) {
        const std::string& value =
            repeated ? reflection.GetRepeatedStringReference(message, field, i, &scratch)
                     : reflection.GetStringReference(message, field, &scratch);
        if (const auto bad = first_bad_utf8(value))
          return name + ": byte " + std::to_string(*bad + 1);
        continue;
      }
      const auto inner =
          field_without_text(repeated ? reflection.GetRepeatedMessage(message, field, i)
                                      : reflection.GetMessage(message, field));
      if (!inner.empty()) return name + "." + inner;
    }
  }
  return {};
}

}  // namespace

namespace {

std::shared_ptr<grpc::ChannelCredentials> credentials_of(const Way& way) {
  if (!way.tls()) return grpc::InsecureChannelCredentials();
  return grpc::SslCredentials({way.authority_pem, way.key_pem, way.certificate_pem});
}

std::string not_kept(const std::string& why) {
  return "The stop could not be kept: " + why +
         ". A daemon that starts, also by itself, goes on with a run that was under way ([run] "
         "after_restart): let none start before somebody has looked at the machine";
}

constexpr int kMostAnswerBytes = 64 * 1024 * 1024;  // as the daemon's limit of what it sends

// gRPC's sentence on a message that is too large is of what the daemon sends or of what this
// program receives, and not of the request: "Sent message larger than max (67108900 vs. 67108864)".
bool is_of_an_answer(const std::string& sentence) {
  return sentence.find("Sent message") != std::string::npos ||
         sentence.find("vs. " + std::to_string(kMostAnswerBytes)) != std::string::npos;
}

// Leaves the stop in the cell's folder for the next start of the daemon. Result: sentences on what
// a start of the daemon will do, kept or not.
std::string keep_wish(const std::string& cell_folder, const std::string& operator_name) {
  if (cell_folder.empty())
    return not_kept("no driftwised.json in this folder says which cell it is");
  const auto path = std::filesystem::absolute(cell_folder) / formats::kKeptStopFile;
  const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
  const UtcTime now{std::chrono::duration_cast<std::chrono::nanoseconds>(since_1970).count()};
  try {
    write_output_file(path.string(), formats::write_kept_stop({operator_name, to_iso8601(now)}));
  } catch (const Failure& failure) {
    return not_kept(failure.message);
  }
  return "The stop is kept in " + path.lexically_normal().string() +
         ": a daemon that starts there, or answers again, stops the axes first; run and queue then "
         "wait for a person";
}

}  // namespace

ExitCode exit_code_of(const grpc::Status& status) {
  switch (status.error_code()) {
    case grpc::StatusCode::OK:
      return ExitCode::done;
    case grpc::StatusCode::INVALID_ARGUMENT:
    case grpc::StatusCode::NOT_FOUND:
      return ExitCode::bad_input;
    case grpc::StatusCode::CANCELLED:  // by the other side, which ends
    case grpc::StatusCode::UNAVAILABLE:
    case grpc::StatusCode::DEADLINE_EXCEEDED:
      return ExitCode::unreachable;
    default:
      return ExitCode::refused;
  }
}

Failure not_halted(const char* done, Failure failure) {
  failure.message.insert(0, std::string("NOT ") + done + ": use the emergency switch. ");
  return failure;
}

Connection::Connection(const Way& way, std::string operator_name, double timeout_s,
                       Interrupt* interrupt, const std::ostream* out)
    : address_(way.address),
      token_(way.token),
      cell_folder_(way.cell_folder),
      certificate_pem_(way.certificate_pem),
      authority_pem_(way.authority_pem),
      tls_(way.tls()),
      operator_name_(std::move(operator_name)),
      timeout_s_(timeout_s),
      interrupt_(interrupt),
      out_(out) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMostAnswerBytes);
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY,
                   0);  // the daemon is on the same network, or at the end of a tunnel
  channel_ = grpc::CreateCustomChannel(address_, credentials_of(way), arguments);
}

void Connection::check_text(const google::protobuf::Message& request) {
  const std::string where = field_without_text(request);
  if (where.empty()) return;
  throw Failure{ExitCode::bad_input, "invalid_argument", "NOT_TEXT",
                where + " is no UTF-8 text: is this the right file? If it is, save it as UTF-8"};
}

void Connection::prepare(grpc::ClientContext& context, double usual_s) const {
  if (!operator_name_.empty()) {
    const bool ascii = std::all_of(operator_name_.begin(), operator_name_.end(),
                                   [](char c) { return c >= 0x20 && c < 0x7F; });
    context.AddMetadata(ascii ? "driftwise-operator" : "driftwise-operator-bin", operator_name_);
  }
  if (!token_.empty()) context.AddMetadata("authorization", "Bearer " + token_);
  const double limit_s = timeout_s_ > 0 ? timeout_s_ : usual_s;
  if (limit_s > 0)
    context.set_deadline(std::chrono::system_clock::now() +
                         std::chrono::milliseconds(static_cast<std::int64_t>(limit_s * 1e3)));
}

// Reason of a refusal by TLS: a client sees a connection that closes, only its files say why.
std::string Connection::hint_of(const grpc::Status& status) const {
  if (!tls_) {
    const bool closed = status.error_message().find("ocket closed") != std::string::npos ||
                        status.error_message().find("reset by peer") != std::string::npos;
    return closed && !address_.starts_with("unix:")
               ? " (it closed the connection: a door with TLS needs --tls-ca)"
               : "";
  }
  const auto now = std::chrono::duration_cast<std::chrono::seconds>(
      std::chrono::system_clock::now().time_since_epoch());
  const std::string doubts = tls::doubts_of(certificate_pem_, authority_pem_, now.count());
  return " (TLS: " + status.error_message() + ")" + (doubts.empty() ? "" : "; " + doubts);
}

void Connection::check(const grpc::Status& status) const {
  if (status.ok()) return;
  if (interrupted()) {
    const Failure left{ExitCode::interrupted, "cancelled", "INTERRUPTED", "interrupted"};
    throw halting_ ? not_halted(halting_, left) : left;
  }
  const auto detail = detail_of(status);
  const bool by_reason = !detail.reason().empty();
  Failure failure{by_reason && status.error_code() == grpc::StatusCode::CANCELLED
                      ? ExitCode::refused
                      : exit_code_of(status),
                  code_text(status.error_code()), detail.reason(), status.error_message()};
  if (!detail.message().empty()) failure.message = detail.message();
  const bool nobody_said_so = !by_reason;
  const std::string tls_words = hint_of(status);
  if (nobody_said_so && status.error_code() == grpc::StatusCode::UNAVAILABLE)
    failure = {
        ExitCode::unreachable, "unavailable", "NO_DAEMON",
        "cannot reach the daemon at " + address_ +
            (halting_ ? ""
                      : ": is driftwised running there? Start it, or name another with --server "
                        "host:port") +
            tls_words};
  if (nobody_said_so && status.error_code() == grpc::StatusCode::CANCELLED)
    failure = {ExitCode::unreachable, "cancelled", "NO_DAEMON",
               "the daemon at " + address_ + " ended meanwhile, or ended this call" +
                   (halting_ ? "" : ": ask again when it has started")};
  if (nobody_said_so && status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED)
    failure = {ExitCode::unreachable, "deadline_exceeded", "TIMEOUT",
               "no answer from " + address_ + " in time" +
                   (halting_ ? tls_words
                             : ": look at `driftwise status`, or allow more with --timeout S")};
  const bool other_program =
      nobody_said_so && status.error_code() == grpc::StatusCode::UNIMPLEMENTED;
  if (other_program)
    failure = {ExitCode::refused, "unimplemented", "OTHER_VERSION",
               "the program at " + address_ + " is no daemon of this version (" +
                   status.error_message() + ")" +
                   (halting_ ? ""
                             : ": compare `driftwise --version` with `driftwised --version` there, "
                               "or name another with --server host:port")};
  // gRPC's own words name no limit that a person knows.
  const bool too_large = nobody_said_so &&
                         status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED &&
                         status.error_message().find("larger than max") != std::string::npos;
  if (too_large && is_of_an_answer(status.error_message()))
    failure = {ExitCode::refused, "resource_exhausted", "ANSWER_TOO_LARGE",
               "the answer is larger than 64 MiB, which is the most that is sent: ask for less, "
               "with --limit, a shorter time or fewer channels where the command has them (" +
                   status.error_message() + ")"};
  else if (too_large)
    failure = {ExitCode::bad_input, "resource_exhausted", "TOO_LARGE",
               "the file is larger than the daemon takes (a dataset of 32 MiB, a trajectory of 8 "
               "MiB): nothing was stored. Give it in parts, or work on the file: driftwise fit, "
               "diagnose and model compare need no daemon (" +
                   status.error_message() + ")"};
  if (!halting_) throw failure;
  // A refusal of a daemon holds for a file too.
  if (failure.reason == "NO_DAEMON" || failure.reason == "TIMEOUT" || other_program)
    failure.message += ". " + keep_wish(cell_folder_, operator_name_);
  throw not_halted(halting_, std::move(failure));
}

}  // namespace driftwise::cli
