#pragma once
// Services of a cell, by reference: what a door (rpc, web, the text line) or a test is given. Each
// takes the one or two that it needs. All on the executor's thread (ports/host.h), but for what
// says otherwise. They live as long as the Cell.

namespace driftwise::application {

class Alarms;
class Annotations;
class Commissioning;
class Configurations;
class Datasets;
class Diagnoses;
class Extensions;
class Feeds;
class Holds;
class Host;
class JointTargets;
class Improvements;
class Indentations;
class Jogs;
class LookBack;
class ManualControl;
class ModelChecks;
class Models;
class Notifications;
class Overview;
class Plans;
class Promotions;
class Provenance;
class Queue;
class RecordKeeping;
class Reports;
class Runs;
class StoreReader;
class Studies;
class SupportBundles;
class Targets;
class Trajectories;

struct Services {
  Host& host;
  Overview& overview;
  StoreReader& records;  // queries that only read the store go here, without a service of their own
  ManualControl& manual;
  Runs& runs;
  Trajectories& trajectories;
  Datasets& datasets;
  Annotations& annotations;
  Models& models;
  Promotions& promotions;
  ModelChecks& checks;
  Targets& targets;
  Provenance& provenance;
  Configurations& configurations;
  Diagnoses& diagnoses;
  Extensions& extensions;
  Improvements& improvements;
  Studies& studies;
  Alarms& alarms;
  Feeds& feeds;
  Queue& queue;
  RecordKeeping& keeping;
  Holds& holds;
  Notifications& notifications;
  Plans& plans;
  JointTargets& joint_targets;
  Jogs& jogs;
  Commissioning& commissioning;
  LookBack& look_back;
  SupportBundles& support;
  Reports& reports;
  Indentations& indentations;
};

}  // namespace driftwise::application
