#include "server/web/grpc_web_frame.h"

#include <cstdint>

#include "server/core/reasons.h"
#include "server/web/base64.h"

namespace driftwise::web {
namespace {

constexpr char kTrailersFlag = static_cast<char>(0x80);
constexpr std::size_t kHeadBytes = 5;

std::string frame_head(char flags, std::size_t bytes) {
  std::string out(1, flags);
  for (const int shift : {24, 16, 8, 0}) out += static_cast<char>(bytes >> shift & 255U);
  return out;
}

std::size_t length_of(std::string_view head) {
  std::size_t out = 0;
  for (std::size_t i = 1; i < kHeadBytes; ++i) out = out << 8 | static_cast<unsigned char>(head[i]);
  return out;
}

// Everything but printable ASCII as %XX, and the percent sign itself.
std::string percent_encoded(std::string_view text) {
  static constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte < 0x7F && c != '%') {
      out += c;
    } else {
      out += '%';
      out += kHex[byte >> 4];
      out += kHex[byte & 15U];
    }
  }
  return out;
}

tl::unexpected<Error> bad_frame(const std::string& found) {
  return fail(ErrorCode::invalid_argument, reasons::kBadFrame,
              "gRPC-Web request: found " + found + ", expected one uncompressed message frame");
}

}  // namespace

std::optional<GrpcWebForm> grpc_web_form(std::string_view content_type) {
  content_type = content_type.substr(0, content_type.find(';'));
  while (content_type.ends_with(' ')) content_type.remove_suffix(1);
  if (content_type == "application/grpc-web" || content_type == "application/grpc-web+proto")
    return GrpcWebForm::binary;
  if (content_type == "application/grpc-web-text" ||
      content_type == "application/grpc-web-text+proto")
    return GrpcWebForm::text;
  return std::nullopt;
}

std::string_view content_type_of(GrpcWebForm form) {
  return form == GrpcWebForm::text ? "application/grpc-web-text+proto"
                                   : "application/grpc-web+proto";
}

Result<std::string> message_of_body(std::string body, GrpcWebForm form) {
  if (form == GrpcWebForm::text) {
    auto bytes = base64_decode(body);
    if (!bytes)
      return fail(ErrorCode::invalid_argument, reasons::kBadBase64,
                  "gRPC-Web request: the body is not base64, as application/grpc-web-text says");
    body = std::move(*bytes);
  }
  if (body.size() < kHeadBytes) return bad_frame(std::to_string(body.size()) + " bytes");
  if (body[0] == 1) return bad_frame("a compressed message");
  if (body[0] != 0) return bad_frame("no message");
  const std::size_t length = length_of(body), follow = body.size() - kHeadBytes;
  if (length > follow)
    return bad_frame("a frame of " + std::to_string(length) + " bytes with " +
                     std::to_string(follow) + " bytes in it");
  if (length < follow)
    return bad_frame(std::to_string(follow - length) + " bytes after the message");
  body.erase(0, kHeadBytes);
  return body;
}

std::string data_frame_head(std::size_t message_bytes) { return frame_head(0, message_bytes); }

std::string trailers_frame(int status, std::string_view message, std::string_view details) {
  std::string text = "grpc-status: " + std::to_string(status) + "\r\n";
  if (!message.empty()) text += "grpc-message: " + percent_encoded(message) + "\r\n";
  if (!details.empty())
    text += "grpc-status-details-bin: " + base64_encode(details, false) + "\r\n";
  return frame_head(kTrailersFlag, text.size()) + text;
}

}  // namespace driftwise::web
