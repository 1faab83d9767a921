#include "clients/cli/commands/data/exported_csv.h"

#include "driftwise/v1/data_service.grpc.pb.h"

namespace driftwise::cli {

std::string exported_csv(const Session& session, const std::vector<std::int64_t>& runs,
                         bool without_excluded) {
  v1::ExportDatasetRequest request;
  for (const std::int64_t run : runs) request.add_run_ids(run);
  request.set_without_excluded(without_excluded);
  std::string csv;
  session.connect().follow(&v1::DataService::Stub::ExportDataset, request,
                           [&csv](const v1::ExportDatasetResponse& response) {
                             csv += response.chunk();
                             return true;
                           });
  return csv;
}

}  // namespace driftwise::cli
