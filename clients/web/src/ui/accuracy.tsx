// The accuracy that heads a page: one figure per unit, which output and rows it is of, its mean and S90, and what it was
// before on the same output and rows.
import type { JudgedAccuracy } from '@/api/gen/driftwise/v1/accuracy_pb';
import { significant } from '@/format/numbers';
import { unitSign } from '@/format/units';
import { A90, S90 } from './explained';

// Three significant digits, and no more decimals than that takes: "42", "12.8", "0.574".
export const figure = (value: number | undefined): string => significant(value, 3).replace(/(\.\d*?)0+$/, '$1').replace(/\.$/, '');
// A mean beside the A90 of the same errors, to the last of the A90's digits: "+24.3" beside 42.0, "+0.62" beside 9.24. A mean
// that the fit makes zero is "0": finer digits of it are the machine's rounding.
export function meanFigure(mean: number | undefined, a90: number | undefined): string {
  const last = a90 ? 10 ** (Math.floor(Math.log10(Number(Math.abs(a90).toPrecision(3)))) - 2) : 0;
  const rounded = mean !== undefined && last > 0 ? Math.round(mean / last) * last : mean;
  return rounded !== undefined && rounded > 0 ? `+${figure(rounded)}` : figure(rounded);
}

const rowWords: Record<string, string> = {
  validation: 'validation rows',
  blocks: 'held-out blocks of time',
  calibration: 'the fit’s own rows, none held out',
  fresh: 'fresh points',
};
export const rowsInWords = (rows: string): string => rowWords[rows] ?? rows;

// "42 nm (q1, validation rows, mean +24.3 nm, S90 12.8 nm)", as the command line says it.
export function accuracyText(one: JudgedAccuracy): string {
  const unit = unitSign(one.unit);
  const before = one.before ? `${figure(one.before.a90)} → ` : '';
  return `${before}${figure(one.figures?.a90)} ${unit} (${one.output}, ${rowsInWords(one.rows)}, mean ${meanFigure(one.figures?.mean, one.figures?.a90)} ${unit}, S90 ${figure(one.figures?.u90)} ${unit})`;
}

export function AccuracyHeading({ of }: { of: readonly JudgedAccuracy[] }) {
  return (
    <>
      {of.map((one) => (
        <div key={`${one.unit} ${one.output}`} class="accuracy-heading" data-accuracy={one.figures?.a90}>
          <p class="muted">accuracy (<A90 />) of {one.output}, {rowsInWords(one.rows)}</p>
          <p class="result nowrap">{one.before && `${figure(one.before.a90)} → `}{figure(one.figures?.a90)} <span class="unit">{unitSign(one.unit)}</span></p>
          <p class="note muted">
            mean {one.before && `${meanFigure(one.before.mean, one.before.a90)} → `}{meanFigure(one.figures?.mean, one.figures?.a90)}, <S90 /> {one.before && `${figure(one.before.u90)} → `}{figure(one.figures?.u90)} {unitSign(one.unit)}
          </p>
        </div>
      ))}
    </>
  );
}
