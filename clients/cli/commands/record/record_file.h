#pragma once
// Answers of RecordService from a database file, without a daemon. The file is opened for reading;
// a daemon may work on it meanwhile. Throws Failure: bad_input naming the file.

#include <string>

#include "driftwise/v1/record_service.pb.h"
#include "server/core/records/copy_records.h"

namespace driftwise::cli {

// "HASH@N"
std::string head_text(const v1::ChainHead& head);
// What a person typed after --head. Throws Failure: usage.
ChainHead kept_head(const std::string& text);
v1::RecordCopy copy_message(const RecordCopy& copy);

v1::ListActsResponse acts_of_file(const std::string& path, const v1::ListActsRequest& request);
v1::GetChainHeadResponse head_of_file(const std::string& path);
v1::VerifyRecordResponse verified_file(const std::string& path,
                                       const v1::VerifyRecordRequest& request);

}  // namespace driftwise::cli
