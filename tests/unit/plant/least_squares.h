#pragma once
// Plain least squares on a campaign, by Eigen's QR: independent of the server's mathematics.

#include <Eigen/Dense>
#include <functional>
#include <vector>

#include "tests/support/plant_campaign.h"

namespace driftwise::testing_support {

// q = constant + columns . b by Eigen's QR with exchange of columns, which are centred and scaled.
class LeastSquares {
 public:
  LeastSquares(const std::vector<std::vector<double>>& rows, const std::vector<double>& q);
  double predicted(const std::vector<double>& row) const;

 private:
  Eigen::RowVectorXd centre_, scale_;
  Eigen::VectorXd solution_;
  double mean_ = 0;
};

double u90(const std::vector<double>& errors);  // 1.645 x standard deviation

using Columns = std::function<std::vector<double>(const CampaignRow&)>;
using Choice = std::function<bool(const CampaignRow&)>;

struct FitFigures {
  double u90_nm = 0;  // on the validation rows
  double p90_nm = 0;  // 90 % of the validation errors are smaller
  double u90_calibration_nm = 0;
};

// Fits q1 on the rows that fitted() chooses, judges on the validation rows.
FitFigures fit_campaign(const std::vector<CampaignRow>& rows, const Columns& columns,
                        const Choice& fitted);

Columns polynomial_and_temperatures(int first_sensor, int last_sensor);  // 1..10; 0, -1: none
Columns oracle_columns();  // x, x^2, true robot and device displacement

}  // namespace driftwise::testing_support
