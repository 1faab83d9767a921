#pragma once
// The demos' tables: the published study beside ours, from what the daemon and the command line
// printed. They compute nothing but differences and standard deviations; fits, predictions and
// targets are the daemon's. Each throws std::exception for a file that is missing or damaged.

#include <string>

namespace driftwise::demo {

// geometry.json, first300.json, six.json, ten.json, offers.json
void print_linear_axis_fits(const std::string& folder);
// {none,geometry,ten,six}.{csv,verify.json} (exported and verified runs) and truth.csv (the plant's
// private log)
void print_linear_axis_proof(const std::string& folder);

// {G,GF,GT,GTF}_{inside,outside}.json, GTF.json, offers.json, campaign.csv
void print_micro_nano_fits(const std::string& folder);
// {compensated,products,geometry}.{csv,verify.json} and truth.csv
void print_micro_nano_proof(const std::string& folder);

// rectification.json; writes scale.txt, the rectified scale of the set-up
void print_min_angle_rectification(const std::string& folder);
// {large,fine}_check_{z,tilts}.csv, fine_{z,tilts}.csv, *.wanted.csv, model2.json, parasitic.csv,
// parasitic_{x,y}.json, ideal/model2.json and truth.csv
void print_min_angle_tables(const std::string& folder);

// tool.csv, tool-model.json, tool-{rx,ry,rz}.json, wanted.csv, by_{plan,geometry}.csv,
// by_plan.verify.json and truth.csv
void print_two_robots_tables(const std::string& folder);
// indentation.toml.state.json and truth.csv
void print_two_robots_contacts(const std::string& folder);

// join.json, joined.csv, configuration-{1,2,3}.csv and truth.csv; writes at_truth.csv: the joined
// data with the true pose in its validation rows
void print_delta_cube_join(const std::string& folder);
// methods.json, methods_truth.json: driftwise.comparison.v1 of joined.csv and of at_truth.csv
void print_delta_cube_methods(const std::string& folder);

// sealed.json (driftwise-cellsim --sealed) and diagnosis.json. True: every cause was named.
bool print_hidden(const std::string& folder);

}  // namespace driftwise::demo
