// Spread of the repeats of each point, and of the attempts that were not taken.
import { Attempt_Verdict, type Attempt } from '@/api/gen/driftwise/v1/run_pb';
import { fixed } from '@/format/numbers';
import { ms } from '@/format/time';
import type { PlotSeries, PlotSpec } from '@/plot/spec';

export function spreadPlot(attempts: readonly Attempt[], startMs: number, limitNm: number | undefined, none = 'No point has been measured yet.'): PlotSpec {
  const measured = attempts.filter((one) => one.spreadNm !== undefined);
  const of = (taken: boolean, more: Partial<PlotSeries>): PlotSeries => {
    const mine = measured.filter((one) => (one.verdict === Attempt_Verdict.ACCEPTED) === taken);
    return {
      unit: 'nm', draw: 'markers', digits: 1, name: '', colour: 'q1',
      x: mine.map((one) => ((ms(one.endTime) ?? NaN) - startMs) / 3600e3),
      y: mine.map((one) => one.spreadNm!),
      keys: mine.map((one) => Number(one.row)),
      ...more,
    };
  };
  const limit = limitNm === undefined ? '' : `, over ${fixed(limitNm)} nm`;
  return {
    title: 'Spread of the repeats',
    what: 'nm against hours since start',
    x: { label: 'time_h', unit: 'h', startMs },
    y: { unit: 'nm' },
    series: [of(true, { name: 'accepted', marker: 'calibration' }), of(false, { name: `measured again${limit}`, marker: 'rejected', colour: 'bad' })],
    ...(limitNm !== undefined && { limits: [{ at: limitNm, label: `limit ${fixed(limitNm)} nm` }] }),
    ...(measured.length === 0 && { why: none }),
  };
}
