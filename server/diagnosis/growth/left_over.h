#pragma once
// What no cause of the catalogue explains, and which findings were only its nearest name. Asked of
// all rows, those held out too: nine places can be joined by anything, and what lies between them
// tells.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/diagnosis/answer/diagnosis.h"
#include "server/diagnosis/growth/extension.h"
#include "server/diagnosis/growth/structure.h"

namespace driftwise::diagnosis {

class Remainder {
 public:
  // longest: blocks that it works with at most.
  Remainder(const Problem& problem, std::size_t longest, const Physics& physics,
            const std::vector<std::string>& excluded, SearchOptions options);

  // The free shape that what is left goes with beyond chance; none where nothing is. cancelled.
  Result<std::optional<LeftOver>> look(const Extension& extension);

  // Of the findings, the one that the last look's shape makes superfluous although more than half
  // as much as it explains was left: a finding is withdrawn when it was only the nearest name for
  // something that the catalogue does not have (NUMERICS.md section 3).
  std::optional<std::size_t> nearest_name(const Extension& extension) const;

  // Findings that together only spell out one free shape of an axis, or of its scale in time, as a
  // series does: a wave and a polynomial on seventeen places, the expansions of two thermometers.
  // Two values or more, and the shape does as well. Ascending; after a look.
  std::vector<std::size_t> spelled_out(const Extension& extension) const;

  const Problem& whole() const { return whole_; }
  const Eigen::MatrixXd& series() const { return series_; }
  SoftBase base(const Extension& extension, std::optional<std::size_t> without = {}) const {
    return whole_base(extension.all(without));
  }

 private:
  SoftBase whole_base(SoftBase base) const;
  // 2 ln L that the last look's shape takes of what is left.
  double left_of(const Extension& extension) const;

  Problem whole_;  // every row learns
  Eigen::MatrixXd series_;
  FreeShapes shapes_;
  Search search_;
  std::optional<Look> last_;
};

}  // namespace driftwise::diagnosis
