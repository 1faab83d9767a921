// The data of a report (docs/web-report.md), read with care: a missing part is missing, an unknown one is passed over.
export interface ReportRun {
  id: number;
  name: string;
  state: string;
  reason: string;
  trajectory: string;
  operator: string;
  start: string | null;
  end: string | null;
  elapsed_s?: number | null;
  rows: number;
  accepted: number;
  given_up: number;
  attempts: number;
  restarts: number;
  compensation?: string;
  metadata?: Record<string, string>;
}

interface WrittenFigures {
  mean: number;
  u90: number;
  a90: number;
  row_count: number;
}
export interface ReportVerification {
  accuracy: { output: string; unit: string; rows: string; figures: WrittenFigures }[];
  row_count: number;
  outside_row_count: number;
  zero_row_count: number;
  outside: string[];
  coordinates: { coordinate: string; unit: string; all: WrittenFigures | null; inside: WrittenFigures | null; outside: WrittenFigures | null; by_model: WrittenFigures | null; largest: number; largest_row: number }[];
}

export interface ReportAttempt {
  row: number;
  number: number;
  verdict: string;
  reason: string;
  spread_nm: number | null;
  time_s: number;
}

export interface ReportEntry {
  id: number;
  name: string;
  state: string;
  reason: string;
  by: string;
  queued: string | null;
  begun: string | null;
  ended: string | null;
  after: number | null;
  condition: string;
  run: number | null;
  results: { follow_up: string | null; good: boolean; text: string; time: string | null }[];
  run_state?: string;
  rows?: number;
  accepted?: number;
  given_up?: number;
  restarts?: number;
}

export interface ReportAlarm {
  id: number;
  kind: string;
  subject: string;
  priority: string;
  state: string;
  message: string;
  consequences: string[];
  since: string | null;
  over: string | null;
  acknowledged: string | null;
  acknowledged_by: string;
}

export interface ReportDiagnosis {
  id: number;
  state: string;
  verdict: string;
  baseline: string;
  extended: string;
  findings: string[];
  left_over: string[];
}

interface WrittenModel {
  id: number;
  name: string;
  formula: string;
  accuracy: ReportVerification['accuracy'];
  count: number;
  time_s: string;
  set: string;
  residuals: { output: string; unit: string; data: string }[];
  trouble: string;
}
export type ReportModel = Omit<WrittenModel, 'count' | 'time_s' | 'set' | 'residuals'> & {
  timeS: number[];
  validation: boolean[];
  residuals: { output: string; unit: string; values: number[] }[];
};

interface Written {
  schema: string;
  cell: string;
  version: string;
  config_hash: string;
  configurations?: { hash: string; from: string | null }[]; // that it was measured under, oldest first
  corrections?: { id: number; since: string; by: string; changes: { channel: string; rows: number; largest_nm: number; rms_nm: number }[] }[];
  made: string;
  certificates?: { device: string; number: string; laboratory: string; date: string; due: string; overdue: boolean }[]; // by the cell file, when the page was made
  record_head?: string | null; // HASH@N of the chain over the record when the page was made
  run: ReportRun;
  rules?: Record<string, number>;
  points: {
    count: number;
    time_s: string;
    row: string;
    line: string;
    set: string;
    zero: string;
    tries: string;
    datum?: string; // whose zero the point counts from; older reports do not say
    columns: { channel: string; base: number; scale: number; data: string }[];
  };
  attempts?: ReportAttempt[];
  events?: { time: string; who: string; what: string; detail: string }[];
  closures?: { line: number; repetition: number; time: string; decision: string; sentence: string }[]; // returns to zero as they were judged
  axes?: { channel: string; min_mm: number; max_mm: number }[];
  verification?: ReportVerification;
  queue?: { entry: number; entries: ReportEntry[] }; // the run's own entry last
  alarms?: ReportAlarm[]; // that stood meanwhile
  models?: WrittenModel[]; // fitted by what followed
  diagnoses?: ReportDiagnosis[];
}

export type Report = Omit<Written, 'points' | 'attempts' | 'events' | 'axes' | 'alarms' | 'models' | 'diagnoses'> & {
  alarms: ReportAlarm[];
  models: ReportModel[];
  diagnoses: ReportDiagnosis[];
  attempts: ReportAttempt[];
  events: NonNullable<Written['events']>;
  axes: NonNullable<Written['axes']>;
  points: { count: number; timeS: number[]; row: number[]; line: number[]; validation: boolean[]; zero: boolean[]; tries: number[]; datum: number[]; columns: { channel: string; values: number[] }[] };
};

export const reportSchema = 'driftwise.run-report.v1';

export function unpacked(base64: string | undefined, count: number): number[] {
  const text = atob(base64 ?? '');
  const bytes = new DataView(Uint8Array.from(text, (c) => c.charCodeAt(0)).buffer);
  return Array.from({ length: count }, (_, i) => (4 * i + 4 <= bytes.byteLength ? bytes.getFloat32(4 * i, true) : NaN));
}

// Errors: what was found and expected, as a sentence.
export function readReport(text: string): Report {
  let written: Written;
  try {
    written = JSON.parse(text) as Written;
  } catch (error) {
    throw new Error(`The data in this page are no JSON (${(error as Error).message}): write the report again.`);
  }
  if (written === null) throw new Error('This page is the empty template. `driftwise report run N -o run.html` writes one with data.');
  if (written.schema !== reportSchema) throw new Error(`The data have schema "${written.schema}", this page reads "${reportSchema}": write the report again with the page of the same version.`);
  const { count, columns } = written.points;
  const of = (packed: string) => unpacked(packed, count);
  return {
    ...written,
    attempts: written.attempts ?? [], events: written.events ?? [], axes: written.axes ?? [], alarms: written.alarms ?? [], diagnoses: written.diagnoses ?? [],
    models: (written.models ?? []).map(({ count: rows, time_s, set, residuals, ...rest }) => ({
      ...rest, timeS: unpacked(time_s, rows), validation: unpacked(set, rows).map((one) => one === 1),
      residuals: residuals.map(({ output, unit, data }) => ({ output, unit, values: unpacked(data, rows) })),
    })),
    points: {
      count, timeS: of(written.points.time_s), row: of(written.points.row), line: of(written.points.line), tries: of(written.points.tries), datum: of(written.points.datum ?? ''),
      validation: of(written.points.set).map((one) => one === 1), zero: of(written.points.zero).map((one) => one === 1),
      columns: columns.map((column) => ({ channel: column.channel, values: of(column.data).map((value) => column.base + value * column.scale) })),
    },
  };
}
