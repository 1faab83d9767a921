// Report of a join of runs (driftwise.join.v1, docs/joined-runs.md).
export interface JoinCheck {
  first: string;
  second: string;
  rows: number;
  largest_row: number;
  [figure: string]: string | number; // median_nm, sigma_nm, largest_nm
}

export interface JoinedChannel {
  channel: string;
  sources: readonly string[];
  unit: string;
  check?: JoinCheck;
  [figure: string]: unknown; // u_nm
}

export interface JoinReport {
  rows: number;
  unmatched_rows: number;
  temperature_difference_k?: number;
  temperature_channel?: string;
  zero_difference_nm?: number;
  channels: readonly JoinedChannel[];
  warnings: readonly string[];
}

// Nothing where the text is no report.
export function joinReport(json: string): JoinReport | undefined {
  try {
    const report = JSON.parse(json) as JoinReport;
    return Array.isArray(report.channels) && Array.isArray(report.warnings) ? report : undefined;
  } catch {
    return undefined;
  }
}

const figureOf = (of: { [key: string]: unknown } | undefined, name: string, unit: string): number | undefined => {
  const value = of?.[`${name}_${unit}`];
  return typeof value === 'number' ? value : undefined;
};

export const uOf = (channel: JoinedChannel): number | undefined => figureOf(channel, 'u', channel.unit);
export const sigmaOf = (channel: JoinedChannel): number | undefined => figureOf(channel.check, 'sigma', channel.unit);
export const medianOf = (channel: JoinedChannel): number | undefined => figureOf(channel.check, 'median', channel.unit);
