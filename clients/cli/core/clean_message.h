#pragma once
// The command line's door in: what a daemon sends ends on a terminal.

#include <google/protobuf/message.h>

namespace driftwise::cli {

// Cleans every text field, those of inner messages too (core/clean_text.h, several lines). Fields
// of bytes stay: they are files.
void clean_message(google::protobuf::Message& message);

}  // namespace driftwise::cli
