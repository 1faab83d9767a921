#pragma once
// gRPC-Web's framing: one byte of flags, four of length (big-endian), the bytes. A request is one
// data frame; an answer is data frames and then one of trailers. Pure.
// github.com/grpc/grpc/blob/master/doc/PROTOCOL-WEB.md

#include <optional>
#include <string>
#include <string_view>

#include "server/core/result.h"

namespace driftwise::web {

enum class GrpcWebForm { binary, text };  // text: every frame in base64, for clients without bytes

// Of a Content-Type: application/grpc-web[+proto], application/grpc-web-text[+proto]; else nothing.
std::optional<GrpcWebForm> grpc_web_form(std::string_view content_type);
std::string_view content_type_of(GrpcWebForm form);

// The message of a request. Errors: invalid_argument BAD_BASE64, BAD_FRAME (too short, a length
// that is not that of what follows, compressed, no message, or several).
Result<std::string> message_of_body(std::string body, GrpcWebForm form);

// Five bytes before a message of this size.
std::string data_frame_head(std::size_t message_bytes);

// status: the gRPC code. details: bytes of grpc-status-details-bin; empty: none.
std::string trailers_frame(int status, std::string_view message, std::string_view details);

}  // namespace driftwise::web
