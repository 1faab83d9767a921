#pragma once
// A second instrument, or a measured work-piece, on the points of a trajectory: scale, offset and
// rotation that bring the reference's coordinates onto the other's, by weighted least squares in
// closed form, and what is left.
//
//   other = offset + scale * R * reference + residual
//
// Sources: S. Umeyama, IEEE Trans. PAMI 13 (1991) 376 (the fit, here with weights); covariance by
// linearisation about it, sigma^2 (J'WJ)^-1 with sigma^2 from the residuals. Pure.

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/result.h"

namespace driftwise::correction {

// Lengths of one instrument by trajectory row.
struct InstrumentRows {
  std::string name;               // "run 3", "cmm.csv": in messages
  std::vector<std::int64_t> row;  // of the trajectory, from 1, each once
  Eigen::MatrixXd mm;             // axes x rows; no missing value
  Eigen::VectorXd u_mm;           // standard uncertainty of each row, any axis; empty: all alike
};

struct InstrumentRules {
  bool scale = true, rotation = true;  // what is fitted; else 1 and none
  std::size_t least_rows = 6;
};

struct InstrumentMatch {
  std::vector<std::string> axes;                   // "x", "y", "z": one to three
  std::vector<std::int64_t> row;                   // common to both, ascending
  std::size_t reference_only = 0, other_only = 0;  // rows that the other side lacks
  double scale_ppm = 0;                            // the other shows this much more
  std::optional<double> u_scale_ppm;               // none: not fitted
  Eigen::VectorXd offset_nm, u_offset_nm;
  Eigen::MatrixXd rotation;  // axes x axes
  // Rotation vector of R: rx, ry, rz of three axes, the one in their plane of two, none of one.
  Eigen::VectorXd rotation_arcsec, u_rotation_arcsec;
  Eigen::MatrixXd residual_nm;  // axes x rows
  Eigen::VectorXd rms_nm;       // of each axis
  // Root of the weighted mean square over the degrees of freedom: 1 where the stated u of the rows
  // explain the residuals. None: no u was stated.
  std::optional<double> birge;
  std::vector<std::string> findings;  // sentences: rows, axes and channels that stand out
};

// Errors: failed_precondition NO_COMMON_ROWS (less than half of either side's rows are in both, or
// fewer than least_rows), ROWS_SHIFTED (moved by one to three rows they agree twice as well),
// POINTS_ON_A_LINE (no rotation can be told); invalid_argument DUPLICATE_ID (a row twice),
// BAD_NUMBER (an uncertainty that is not above 0).
Result<InstrumentMatch> match_instruments(const InstrumentRows& reference,
                                          const InstrumentRows& other,
                                          const std::vector<std::string>& axes,
                                          const InstrumentRules& rules = {});

}  // namespace driftwise::correction
