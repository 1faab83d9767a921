#pragma once
// What tilts do must be told from geometry: a robot that tilts where it goes carries the shape of
// its tilts over the workspace, and a lever on them is a polynomial of the pose. Only what tilts do
// beyond such a polynomial (under force, with heat) speaks for the lever. A wave, too: 10.00012 um
// along places that are whole multiples of 10 um is one slow turn over 0.8 m, and as smooth as what
// the geometry lacks. And one of the lattice's own spacing is a constant but for a few per cent:
// what the baseline leaves of it is the difference between the pose as it was read and as the
// motors predict it, and explains the readings' noise. And one that is far shorter than the places
// are apart gives a dozen of them any values, as one of a thousand periods fits: it must leave
// nothing that free values of the places would explain.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "server/diagnosis/catalogue/cause.h"
#include "server/diagnosis/noise/ground.h"
#include "server/diagnosis/rows/problem.h"

namespace driftwise::diagnosis {

class ToldFromGeometry {
 public:
  explicit ToldFromGeometry(const Problem& problem);  // which outlives it

  // columns: of the cause at this parameter, one row per block; shape: of the noise, per output
  // (Gain::shape). Does at least half of what the columns of a lever on tilts explain stay when
  // geometry is free? Does the baseline leave a tenth of a wave's rms, has one of eight periods or
  // more along a coordinate more than two on these places, and does it, of several motors, explain
  // half as much where each row stands at its place in the mean? Else it is a function of what the
  // other motors do to the axis within a place: a guide that is not straight, the rounding of what
  // they read. Does a wave shorter than the places are apart explain what free values of the places
  // do, but for what chance gives them and their number costs? True for every other cause.
  bool operator()(const Cause& cause, double parameter, const Eigen::MatrixXd& columns,
                  const std::vector<std::size_t>& shape, const Ground& ground) const;

 private:
  bool turns_on_these_places(const Cause& cause, double period,
                             const Eigen::MatrixXd& columns) const;
  // Each row's coordinate as it is, and as the rows at its place have it in the mean, with the
  // wave's period, all in the coordinate's unit.
  struct Places {
    std::vector<double> values, places;
    double period = 0;
  };
  // Nothing where the cause has no coordinate, or this one no places that lie much further apart
  // than the rows at each of them.
  std::optional<Places> places_of(const Cause& cause, double parameter) const;
  bool goes_with_its_places(const Places& where, const Eigen::MatrixXd& columns,
                            const std::vector<std::size_t>& shape, const Ground& ground) const;
  bool explains_its_places(const Places& where, const Eigen::MatrixXd& columns,
                           const std::vector<std::size_t>& shape, const Ground& ground) const;

  const Problem& problem_;
  std::ptrdiff_t motors_ = 0;
  Eigen::MatrixXd geometry_;  // blocks x monomials of the pose
};

}  // namespace driftwise::diagnosis
