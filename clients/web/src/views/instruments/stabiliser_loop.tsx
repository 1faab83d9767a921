// The control loop of a stabiliser as its controller has it, beside what the cell file declares; and how it is set.
import { useState } from 'preact/hooks';
import { api } from '@/api/client';
import type { GetStabiliserResponse, StabiliserTuning } from '@/api/gen/driftwise/v1/cell_service_pb';
import { withLease } from '@/app/lease';
import { significant } from '@/format/numbers';
import { secondsOf } from '@/format/time';
import { Button, CommandButton } from '@/ui/button';
import { confirm } from '@/ui/confirm';
import { Field, numberTyped } from '@/ui/field';
import { Awaiting, Failed } from '@/ui/states';
import { useAsked } from '@/ui/use_asked';
import { useCommand } from '@/ui/use_command';
import { Verdict } from '@/ui/verdict';

const parts = ['heat band', 'cool band', 'integral', 'derivative'] as const;
type Part = (typeof parts)[number];
const unitOf = (part: Part) => (part.endsWith('band') ? 'K' : 's');
const most = (part: Part) => (part.endsWith('band') ? 5000 : 9999);

// Bands go from 0.001 to 5000 K: "0.5", "13.89", "1200".
const figure = (value: number | undefined): string => significant(value, 4).replace(/\.0+$|(\.\d*[1-9])0+$/, '$1');

export const valuesOf = (tuning: StabiliserTuning | undefined): Record<Part, number | undefined> => ({
  'heat band': tuning?.heatBandK, 'cool band': tuning?.coolBandK,
  integral: tuning?.integralDuration && secondsOf(tuning.integralDuration), derivative: tuning?.derivativeDuration && secondsOf(tuning.derivativeDuration),
});

const duration = (seconds: number) => ({ seconds: BigInt(Math.floor(seconds)), nanos: Math.round((seconds - Math.floor(seconds)) * 1e9) });

function Tune({ device, now, done }: { device: string; now: GetStabiliserResponse; done: () => void }) {
  const [typed, setTyped] = useState<Partial<Record<Part, string>>>({});
  const before = valuesOf(now.tuning);
  const wanted = parts.flatMap((part) => {
    const value = numberTyped(typed[part] ?? '');
    return typed[part] && value !== undefined ? [{ part, value }] : [];
  });
  const wrong = (part: Part): string | undefined => {
    const [text, value] = [typed[part] ?? '', numberTyped(typed[part] ?? '')];
    if (text === '') return undefined;
    return value === undefined || value < 0 || value > most(part) || (part.endsWith('band') && value === 0) ? `A number up to ${most(part)} ${unitOf(part)}` : undefined;
  };
  const off = parts.map(wrong).find(Boolean) ?? (wanted.length === 0 ? 'Type what is to change first' : undefined);
  const set = useCommand(() => withLease((leaseToken) => {
    const of = (part: Part) => wanted.find((one) => one.part === part)?.value;
    const [heat, cool, integral, derivative] = parts.map(of);
    return api.cell().tuneStabiliser({
      leaseToken, deviceId: device,
      tuning: {
        ...(heat !== undefined && { heatBandK: heat }), ...(cool !== undefined && { coolBandK: cool }),
        ...(integral !== undefined && { integralDuration: duration(integral) }), ...(derivative !== undefined && { derivativeDuration: duration(derivative) }),
      },
    });
  }));
  const ask = async () => {
    const yes = await confirm({
      title: `Set the control loop of ${device}?`,
      facts: [
        ...wanted.map(({ part, value }) => [part, `${figure(before[part])} ${unitOf(part)} → ${value} ${unitOf(part)}`] as const),
        ['affects', 'the instruments on this support: a loop that is too sharp oscillates'],
      ],
      verb: 'Set it', keep: 'Keep it as it is',
    });
    if (yes && (await set.send())) done();
  };
  return (
    <form class="stack" onSubmit={(event) => { event.preventDefault(); if (!off) void ask(); }}>
      {parts.map((part) => (
        <Field key={part} label={part} unit={unitOf(part)} type="number" value={typed[part] ?? ''} onInput={(text) => setTyped({ ...typed, [part]: text })} wrong={wrong(part)} hint={`now ${figure(before[part])}`} />
      ))}
      <div class="actions">
        <CommandButton kind="main" submit busy={set.busy} off={off}>Set…</CommandButton>
        <Button onPress={done}>Cancel</Button>
      </div>
      {set.failure && <Failed asked={`Tune ${device}`} failure={set.failure} />}
    </form>
  );
}

export function StabiliserLoop({ device }: { device: string }) {
  const loop = useAsked(`loop of ${device}`, (signal) => api.cell().getStabiliser({ deviceId: device }, { signal }));
  const [tuning, setTuning] = useState(false);
  if (loop.failure) return <Failed asked={`Read the loop of ${device}`} failure={loop.failure} again={loop.again} />;
  if (!loop.value) return <Awaiting what="the control loop" />;
  const [values, declared] = [valuesOf(loop.value.tuning), valuesOf(loop.value.declared)];
  return (
    <>
      <dl class="facts note">
        {parts.map((part) => (
          <>
            <dt>{part}</dt>
            <dd>{figure(values[part])} {unitOf(part)}{declared[part] !== undefined && `, declared ${figure(declared[part])}`}</dd>
          </>
        ))}
      </dl>
      {loop.value.differences.map((sentence) => <Verdict key={sentence} kind="warn">{sentence}</Verdict>)}
      {tuning ? <Tune device={device} now={loop.value} done={() => { setTuning(false); loop.again(); }} /> : <CommandButton label={`Loop… of ${device}: set it`} onPress={() => setTuning(true)}>Loop…</CommandButton>}
    </>
  );
}
