#include "server/correction/described_stage.h"

namespace driftwise::correction {

Stage stage_from(const CorrectionDescription& description, std::string_view robot) {
  Stage stage;
  stage.cosine = description.cosine;
  for (const auto& beam : description.beams) {
    if (robot_of(beam.length.symbol) != robot) continue;
    const auto axis = static_cast<std::size_t>(beam.length.symbol.back() - 'x');
    stage.beams[axis] = {beam.offset_mm, beam.offset_per_mm};
    stage.directions_arcsec[axis] = beam.direction_arcsec;
  }
  return stage;
}

}  // namespace driftwise::correction
