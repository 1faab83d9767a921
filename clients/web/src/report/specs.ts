// The plots of a report.
import { kindOf, ofOneRobot, splitChannel, unitSign } from '@/format/units';
import { lookOf } from '@/plot/many';
import { eventMarks, forceSteps } from '@/parts/time_marks';
import { driftOf, lengthsOf } from '@/parts/zero_drift';
import type { TimeMark } from '@/plot/marks';
import type { Colour, PlotSeries, PlotSpec } from '@/plot/spec';
import type { PoseScene } from '@/poses/pose';
import type { Report } from './data';

const colours: readonly Colour[] = ['q1', 'q2', 'q3', 's4', 's5', 's6'];
const hours = (report: Report) => report.points.timeS.map((t) => t / 3600);
const file = (report: Report, what: string) => `run-${report.run.id}-${what}`;
const x = (report: Report) => ({ label: 'time_h', unit: 'h', ...(report.run.start ? { startMs: Date.parse(report.run.start) } : {}) });

const valuesOf = (report: Report, channel: string) => report.points.columns.find((one) => one.channel === channel)?.values;

// The worst of a point's interferometers, nm.
export function spreads(report: Report): number[] | undefined {
  const columns = report.points.columns.filter((one) => /_std_nm$/.test(one.channel));
  if (columns.length === 0) return undefined;
  return report.points.timeS.map((_, i) => {
    const known = columns.map((one) => one.values[i]).filter(Number.isFinite);
    return known.length ? Math.max(...known) : NaN;
  });
}

export function spreadSpec(report: Report): PlotSpec {
  const y = spreads(report) ?? [];
  const time = hours(report);
  const pick = (validation: boolean): PlotSeries => {
    const rows = y.map((_, i) => i).filter((i) => report.points.validation[i] === validation && Number.isFinite(y[i]));
    return {
      name: validation ? 'validation' : 'calibration', unit: 'nm', colour: validation ? 'q2' : 'q1', draw: 'markers', marker: validation ? 'validation' : 'calibration',
      x: rows.map((i) => time[i]), y: rows.map((i) => y[i]), keys: rows, digits: 1,
    };
  };
  const again = report.attempts.filter((one) => one.spread_nm !== null).sort((a, b) => a.time_s - b.time_s);
  const rejected: PlotSeries = {
    name: 'measured again', unit: 'nm', colour: 'bad', draw: 'markers', marker: 'rejected', x: again.map((one) => one.time_s / 3600), y: again.map((one) => one.spread_nm ?? NaN), digits: 1,
  };
  const limit = report.rules?.['max_spread_nm'];
  return {
    title: 'Spread of the repeats', what: 'nm against hours since start', x: x(report), y: { unit: 'nm' }, series: [pick(false), pick(true), rejected].filter((one) => one.x.length > 0),
    limits: limit === undefined ? [] : [{ at: limit, label: `limit ${limit} nm` }], file: file(report, 'spread'), ...(y.length === 0 ? { why: 'The points carry no spread.' } : {}),
  };
}

// Drift of the zero: readings of the instruments at each return to zero, against the first of the same datum.
export function zeroSpec(report: Report): PlotSpec {
  const rows = report.points.zero.map((zero, i) => (zero ? i : -1)).filter((i) => i >= 0);
  const time = hours(report);
  const returns = rows.map((i) => ({ datum: report.points.datum[i], hours: time[i], row: report.points.row[i], value: (channel: string) => valuesOf(report, channel)![i] }));
  const drift = driftOf(returns, lengthsOf(report.points.columns.map((one) => one.channel)));
  const series = drift.lengths.map((channel, k): PlotSeries => (
    { name: splitChannel(channel).symbol, unit: 'nm', colour: colours[k % colours.length], x: drift.hours, y: drift.nm[k], digits: 1 }
  ));
  return {
    title: 'Drift of the zero', what: 'nm against hours since start, at the returns to zero', x: x(report), y: { unit: 'nm', low: -5, high: 5 }, series, file: file(report, 'zero'),
    ...(rows.length < 2 ? { why: 'The run returned to zero less than twice.' } : {}),
  };
}

export function temperatureSpec(report: Report): PlotSpec {
  const time = hours(report);
  const columns = report.points.columns.filter((one) => /_degC$/.test(one.channel) && !/_set_degC$/.test(one.channel) && one.values.some(Number.isFinite));
  return {
    title: 'Temperatures', what: '°C against hours since start', x: x(report), y: { unit: 'degC', zero: false }, deviation: columns.length > 6,
    series: columns.map((one, i): PlotSeries => ({ name: splitChannel(one.channel).symbol.replaceAll('_', ' '), unit: 'degC', ...lookOf(i), quiet: columns.length > 6, x: time, y: one.values, digits: 3 })),
    file: file(report, 'temperatures'), ...(columns.length === 0 ? { why: 'No temperature was recorded with the points.' } : {}),
  };
}

export function forceSpec(report: Report): PlotSpec | undefined {
  const values = valuesOf(report, 'force_N');
  if (!values?.some(Number.isFinite)) return undefined;
  return {
    title: 'Force', what: 'N against hours since start', x: x(report), y: { unit: 'N' }, series: [{ name: 'force', unit: 'N', colour: 's6', draw: 'steps', x: hours(report), y: values, digits: 3 }], file: file(report, 'force'),
  };
}

export function marksOf(report: Report): TimeMark[] {
  const startMs = Date.parse(report.run.start ?? '');
  return [
    ...forceSteps(valuesOf(report, 'force_N') ?? []).map(({ index, label }) => ({ kind: 'force' as const, label, atMs: startMs + report.points.timeS[index] * 1000 })),
    ...eventMarks(report.events.map((event) => ({ atMs: Date.parse(event.time), what: event.what, detail: event.detail }))),
  ];
}

export function poseScene(report: Report): PoseScene | undefined {
  const channels = ofOneRobot(report.points.columns.map((one) => one.channel).filter((name) => kindOf(name) === 'motor' && /q\d+_mm$/.test(name))).slice(0, 3);
  if (channels.length < 2) return undefined;
  const spread = spreads(report);
  const limited = channels.every((channel) => report.axes.some((axis) => axis.channel === channel));
  const axes = [0, 1, 2].map((i) => {
    const channel = channels[i];
    if (!channel) return { name: '', unit: 'mm', low: 0, high: 0 };
    const limit = report.axes.find((axis) => axis.channel === channel);
    const values = valuesOf(report, channel)!.filter(Number.isFinite);
    return { name: splitChannel(channel).symbol, unit: unitSign('mm'), low: limit?.min_mm ?? Math.min(...values), high: limit?.max_mm ?? Math.max(...values) };
  });
  return {
    title: 'Poses', axes: axes as unknown as PoseScene['axes'], box: limited ? 'soft limits' : 'range of the points', path: true,
    colour: spread ? { what: 'spread', unit: 'nm', by: 'value' } : { what: 'order of visit', unit: '', by: 'order' },
    poses: report.points.timeS.map((_, i) => ({
      at: [0, 1, 2].map((k) => (channels[k] ? valuesOf(report, channels[k])![i] : 0)) as [number, number, number],
      key: i, set: report.points.zero[i] ? 'zero' : report.points.validation[i] ? 'validation' : 'calibration', value: spread?.[i],
    })),
  };
}
