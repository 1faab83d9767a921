// A grid with returns to zero, points for validation between those for calibration, and forces. The daemon makes it; what
// comes back is a text like any other, checked and shown before it is kept.
import { useState } from 'preact/hooks';
import { trajectoryApi } from '@/api/trajectory';
import { countRows } from '@/format/numbers';
import { splitChannel } from '@/format/units';
import { Button } from '@/ui/button';
import { Field, numberTyped } from '@/ui/field';
import { Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';
import { useTyped } from '@/ui/use_typed';
import { useLimits, type SoftLimit } from '@/trajectory/limits';

interface AxisTyped {
  from: string;
  to: string;
  count: string;
}

export function GenerateForm({ onText }: { onText: (text: string, name: string) => void }) {
  const limits = useLimits();
  return (
    <details>
      <summary>or generate a grid</summary>
      {limits.failure && <Failed asked="Ask for the soft limits" failure={limits.failure} again={limits.again} />}
      {limits.value && <Form axes={limits.value.axes} onText={onText} />}
    </details>
  );
}

// A tenth of the way within the limits.
const within = (axis: SoftLimit): AxisTyped => {
  const room = 0.1 * (axis.max - axis.min);
  return { from: (axis.min + room).toFixed(2), to: (axis.max - room).toFixed(2), count: '5' };
};

const forcesOf = (text: string): number[] | undefined => {
  const parts = text.split(/[\s;]+/).filter(Boolean).map(numberTyped);
  return parts.every((one) => one !== undefined) ? (parts as number[]) : undefined;
};

function Form({ axes, onText }: { axes: readonly SoftLimit[]; onText: (text: string, name: string) => void }) {
  const [typed, setTyped] = useState<Record<string, AxisTyped>>(() => Object.fromEntries(axes.map((axis) => [axis.channel, within(axis)])));
  const [line, setLine] = useTyped('grid.line', '0');
  const [forces, setForces] = useTyped('grid.forces');
  const [repeats, setRepeats] = useTyped('grid.repeats', '1');
  const [seed, setSeed] = useTyped('grid.seed');
  const [validation, setValidation] = useState(true);
  const [both, setBoth] = useState(false);
  const [made, setMade] = useState<bigint>();
  const wrongOf = (axis: SoftLimit): string | undefined => {
    const { from, to, count } = typed[axis.channel];
    const [low, high, n] = [from, to, count].map(numberTyped);
    if (low === undefined || high === undefined || n === undefined) return 'numbers are expected';
    if (!(low < high)) return 'from has to be below to';
    if (low < axis.min || high > axis.max) return `soft limits: ${axis.min} to ${axis.max} mm`;
    return n >= 1 && Number.isInteger(n) ? undefined : 'a whole number of positions';
  };
  const wrong = axes.map(wrongOf).find(Boolean) ?? (forcesOf(forces) ? undefined : 'forces: numbers parted by blanks are expected');
  const make = useCommand(async () => {
    const answer = await trajectoryApi().generateTrajectory({
      axes: axes.map((axis) => {
        const { from, to, count } = typed[axis.channel];
        return { coordinate: axis.channel, fromMm: numberTyped(from)!, toMm: numberTyped(to)!, count: numberTyped(count)! };
      }),
      lineLength: numberTyped(line) ?? 0, withValidation: validation, forcesN: forcesOf(forces) ?? [], repeatCount: numberTyped(repeats) ?? 1, bothDirections: both,
      ...(numberTyped(seed) !== undefined ? { shuffleSeed: BigInt(Math.round(numberTyped(seed)!)) } : {}),
    });
    setMade(answer.rowCount);
    onText(answer.text, `grid-${axes.map((axis) => typed[axis.channel].count).join('x')}${forces.trim() ? '-force' : ''}`);
  });
  const change = (channel: string, key: keyof AxisTyped) => (text: string) => setTyped((old) => ({ ...old, [channel]: { ...old[channel], [key]: text } }));
  return (
    <div class="stack trajectories-generate">
      {axes.map((axis) => {
        const { symbol } = splitChannel(axis.channel);
        return (
          <div class="trajectories-axis" key={axis.channel} role="group" aria-label={`Grid of ${symbol}`}>
            <strong>{symbol}</strong>
            <Field label={`${symbol} from`} unit="mm" type="number" value={typed[axis.channel].from} onInput={change(axis.channel, 'from')} />
            <Field label={`${symbol} to`} unit="mm" type="number" value={typed[axis.channel].to} onInput={change(axis.channel, 'to')} />
            <Field label={`${symbol} positions`} type="number" value={typed[axis.channel].count} onInput={change(axis.channel, 'count')} />
            {wrongOf(axis) && <span class="note trajectories-wrong">{wrongOf(axis)}</span>}
          </div>
        );
      })}
      <div class="row trajectories-options">
        <Field label="points between returns to zero" type="number" value={line} onInput={setLine} hint="0: one line of the first axis" />
        <Field label="forces, one after the other" unit="N" value={forces} onInput={setForces} hint="parted by blanks; empty: none" />
        <Field label="repeats" type="number" value={repeats} onInput={setRepeats} />
        <Field label="seed of a random order" type="number" value={seed} onInput={setSeed} hint="empty: in order" />
        <label class="trajectories-check"><input type="checkbox" checked={validation} onChange={(event) => setValidation(event.currentTarget.checked)} /> validation points in the middle of the cells</label>
        <label class="trajectories-check"><input type="checkbox" checked={both} onChange={(event) => setBoth(event.currentTarget.checked)} /> every second pass backwards</label>
      </div>
      <div class="actions">
        <Button busy={make.busy} off={wrong} onPress={() => make.send()}>Generate</Button>
        {made !== undefined && <span class="muted">{countRows(made)}, shown below</span>}
      </div>
      {make.failure && <Failed asked="Generate the grid" failure={make.failure} />}
    </div>
  );
}
