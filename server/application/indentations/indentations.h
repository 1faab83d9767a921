#pragma once
// Indentations: the record of a procedure that a client executes, and its table of indents.
// Executor's thread; texts are read on the text thread.

#include <optional>
#include <string>
#include <vector>

#include "server/application/ports/caller.h"
#include "server/core/ports/awaitable.h"
#include "server/core/records/indentation_record.h"
#include "server/core/result.h"
#include "server/indentation/tip_model.h"

namespace driftwise::application {

struct IndentationView {
  IndentationRecord record{};
  std::string name{}, tool{}, stage{};
  std::int64_t revision = 0;  // of the procedure's record: its age
  int contacts = 0, made = 0, planned = 0;
  bool in_contact = false;
  std::string table_json{};     // empty: no table, or none that can be computed
  std::string table_trouble{};  // why it cannot be computed
  std::string verdict{};
  std::optional<indentation::Conformity> conformity{};  // with the wanted accuracy, by the table
};

class Indentations {
 public:
  static constexpr std::size_t kMostFileBytes = 64 * 1024;
  static constexpr std::size_t kMostRecordBytes = 1024 * 1024;
  static constexpr std::size_t kMostKeyBytes = 64;

  virtual ~Indentations() = default;
  // Errors: invalid_argument, those of read_indentation_file and read_procedure_json, BAD_VALUE of
  // the key; failed_precondition NOT_NOW (the stored record of this key is a later revision),
  // OTHER_TOOL (the stored record was begun with another).
  virtual Awaitable<Result<IndentationView>> begin(Caller caller, std::string key,
                                                   std::string file_text,
                                                   std::string record_json) = 0;
  // ended: reason of the client's end; empty: it continues. Errors: as above; NO_SUCH_RECORD.
  virtual Awaitable<Result<IndentationView>> report(Caller caller, IndentationId id,
                                                    std::string record_json, std::string ended) = 0;
  // Errors: those of read_microscope_csv, indents_seen, indent_table, tip_report; NOT_NOW,
  // OTHER_TOOL.
  virtual Awaitable<Result<IndentationView>> import_table(Caller caller, IndentationId id,
                                                          std::string microscope_csv) = 0;
  virtual Awaitable<Result<std::vector<IndentationView>>> list(int limit) = 0;  // newest first
  virtual Awaitable<Result<IndentationView>> get(IndentationId id) = 0;
};

}  // namespace driftwise::application
