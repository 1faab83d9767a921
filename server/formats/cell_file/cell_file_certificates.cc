#include "server/formats/cell_file/cell_file_certificates.h"

#include "server/formats/text/text.h"

namespace driftwise::formats {
namespace {

void read_day(TomlReader& reader, const char* key, std::string& day, Need need) {
  reader.text(key, day, need);
  if (!day.empty() && !calendar_day_from(day))
    reader.refuse(key, reasons::kBadDate,
                  "found " + shown(day) + ", expected a day such as \"2026-03-01\"");
}

}  // namespace

void read_certificate(TomlReader&& reader, CellDescription& out) {
  CertificateDescription one;
  reader.text("device", one.device, Need::required);
  if (!one.device.empty() && out.find_device(one.device) == nullptr)
    reader.refuse("device", reasons::kNoDevice,
                  "found " + shown(one.device) + ", which is no device of this cell");
  reader.text("number", one.number, Need::required);
  reader.text("laboratory", one.laboratory, Need::required);
  read_day(reader, "date", one.date, Need::required);
  read_day(reader, "due", one.due, Need::optional);
  if (const auto from = calendar_day_from(one.date), to = calendar_day_from(one.due);
      from && to && to->days < from->days)
    reader.refuse("due", reasons::kBadDate,
                  "found " + shown(one.due) + ", which is before the date of the certificate");
  for (const auto& other : out.certificates)
    if (other.device == one.device && other.number == one.number)
      reader.refuse("number", reasons::kDuplicateId,
                    "found " + shown(one.number) + ", which " + shown(one.device) + " has already");
  reader.finish();
  out.certificates.push_back(std::move(one));
}

}  // namespace driftwise::formats
