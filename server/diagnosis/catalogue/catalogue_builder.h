#pragma once
// What the parts of the catalogue are built with: which channels the data have and vary, which
// terms the simulation knows already. Private to this room.

#include <functional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "server/diagnosis/catalogue/cause.h"

namespace driftwise::diagnosis {

class CatalogueBuilder {
 public:
  CatalogueBuilder(const Dataset& dataset, const std::vector<effects::Term>& base,
                   const std::vector<std::string>& excluded);

  const Dataset& data() const { return dataset_; }
  const std::vector<std::string>& temperatures() const { return temperatures_; }
  // Coordinates of the pose that vary: x y z, and of rx ry rz those that the simulation reads. A
  // tilt that it does not read is an instrument's reading.
  const std::vector<std::string>& axes() const { return axes_; }
  const std::vector<std::string>& lengths() const { return lengths_; }  // of axes(): x y z
  const std::vector<std::string>& tilts() const { return tilts_; }      // rx ry rz that vary
  const std::vector<std::string>& motors() const { return motors_; }
  bool is_angle(const std::string& symbol) const;
  // Conditions that are no temperature, air, force, coordinate or setting: speed, current, duty.
  const std::vector<std::string>& activities() const { return activities_; }
  bool timed() const { return length_s_ > 0; }
  double length_s() const { return length_s_; }
  double step_s() const { return step_s_; }  // typical, between rows
  bool varies(const std::string& symbol) const;
  double range(const std::string& symbol) const;
  bool known(const effects::Term& term) const;  // in the simulation

  void missing(const std::string& cause, const std::string& why);
  // One cell of all those terms that the simulation lacks; none if it has them all.
  void add_terms(Cause& cause, const std::vector<effects::Term>& terms, double parameter) const;
  // One cell per value that the effect allows. None: missing().
  void add_values(Cause& cause, const std::vector<double>& values,
                  const std::function<std::vector<effects::Term>(double)>& terms);
  void take_cause(Cause cause);  // if it has cells
  Catalogue take() { return std::move(catalogue_); }

 private:
  const Dataset& dataset_;
  std::set<std::string> known_, excluded_;
  std::vector<std::string> temperatures_, axes_, lengths_, tilts_, motors_, activities_;
  double length_s_ = 0, step_s_ = 0;
  Catalogue catalogue_;
};

// Of two channels over the rows that have both: the slope of the second over the first and what a
// straight line leaves of it. All 0 where the first does not vary.
struct StraightLine {
  double slope = 0, left_rms = 0, correlation = 0;
};
StraightLine straight_line(std::span<const double> from, std::span<const double> to);

// Step in 1/period of a grid of waves over a range, of so many half turns at most. A wave half a
// step off its cell keeps sinc^2(range x step / 2) of its evidence: 95 % with a quarter of a turn
// over the range, 81 % with half of one. The latter where the finer grid would be too large.
double wave_step(double range, std::size_t half_turns);

// low to high, at least two values; empty where there is no room.
std::vector<double> log_grid(double low, double high);

effects::Term power_term(const std::string& symbol, int exponent = 1);
// x^degree, x^(degree-1):y, ...: every product of these coordinates of one total degree.
std::vector<effects::Term> monomials_of_degree(const std::vector<std::string>& axes, int degree);
effects::Term call_term(const std::string& effect, std::vector<std::string> symbols,
                        std::vector<effects::Quantity> parameters = {});

void add_geometry(CatalogueBuilder& builder);      // catalogue_geometry.cc
void add_temperatures(CatalogueBuilder& builder);  // catalogue_conditions.cc
void add_force(CatalogueBuilder& builder);
void add_motion(CatalogueBuilder& builder);  // catalogue_motion.cc
void add_probes(CatalogueBuilder& builder);
void add_activities(CatalogueBuilder& builder);
void add_beams(CatalogueBuilder& builder);  // catalogue_beams.cc
void add_time(CatalogueBuilder& builder);   // catalogue_time.cc

}  // namespace driftwise::diagnosis
