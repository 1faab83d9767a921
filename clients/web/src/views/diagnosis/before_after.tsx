// Measured minus simulated, before and after the extension, on one scale; against time or anything it may go with.
import { useMemo } from 'preact/hooks';
import type { DiscrepancyRows, OutputDiscrepancy } from '@/api/gen/driftwise/v1/diagnosis_service_pb';
import { query, setQuery } from '@/app/router';
import { significant } from '@/format/numbers';
import { unitSign } from '@/format/units';
import { Plot } from '@/plot/plot';
import { SymbolChoice } from '@/ui/choice';
import { Panel } from '@/ui/panel';
import { after, before } from './words';
import { axisOf, axesOf, discrepancySpec } from './specs';

export function BeforeAfter({ rows, output, symbols }: { rows: DiscrepancyRows; output: OutputDiscrepancy; symbols: readonly string[] }) {
  const axes = useMemo(() => axesOf(rows), [rows]);
  const wanted = query('against');
  const axis = axes.includes(wanted ?? '') ? wanted! : axes[0];
  const colour = query('colour') ?? 'set';
  const specs = useMemo(() => {
    const x = axisOf(rows, axis);
    return [
      discrepancySpec(rows, output, x, colour, 'before', `Before: ±${significant(before(output))} ${output.unit}`),
      discrepancySpec(rows, output, x, colour, 'after', `After: ±${significant(after(output))} ${output.unit}`),
    ];
  }, [rows, output, axis, colour]);
  const words = (symbol: string) => {
    if (symbol === 'time' || symbol === 'row') return symbol;
    const unit = rows.variables.find((one) => one.symbol === symbol)?.unit ?? '';
    return `${symbol}${unit && `, ${unitSign(unit)}`}`;
  };
  return (
    <>
      <div class="row diagnosis-choices">
        {symbols.length > 1 && <div class="field"><span>output</span><SymbolChoice symbols={symbols} /></div>}
        <label class="field diagnosis-axis"><span>against</span>
          <select value={axis} onChange={(event) => setQuery({ against: event.currentTarget.value === axes[0] ? undefined : event.currentTarget.value })}>
            {axes.map((symbol) => <option key={symbol} value={symbol}>{words(symbol)}</option>)}
          </select>
        </label>
        <label class="field diagnosis-axis"><span>colour by</span>
          <select value={colour} onChange={(event) => setQuery({ colour: event.currentTarget.value === 'set' ? undefined : event.currentTarget.value })}>
            <option value="set">set: calibration, validation</option>
            <option value="line">line: odd, even</option>
            <option value="direction">direction of approach</option>
          </select>
        </label>
      </div>
      <div class="columns">{specs.map((spec) => <Panel key={spec.title}><Plot spec={spec} height={230} group="discrepancy" /></Panel>)}</div>
    </>
  );
}
