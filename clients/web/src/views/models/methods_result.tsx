// What a comparison of methods found: a row per method, its error per output as bar and number on one logarithmic scale.
import type { CompareMethodsResponse, MethodOutcome, MethodOutcome_Output } from '@/api/gen/driftwise/v1/model_service_pb';
import { query } from '@/app/router';
import { fixed, significant } from '@/format/numbers';
import { secondsOf } from '@/format/time';
import { splitChannel, unitSign } from '@/format/units';
import { Bar } from '@/ui/bar';
import { Button } from '@/ui/button';
import { SymbolChoice } from '@/ui/choice';
import { download } from '@/ui/download';
import { A90 } from '@/ui/explained';
import { Panel } from '@/ui/panel';
import { Empty, Warned } from '@/ui/states';
import { Table } from '@/ui/table';
import { Verdict } from '@/ui/verdict';
import { GeometryPanel } from './geometry';
import { intervalOf, methodsOf, type MethodJson } from './methods_json';
import { logScale } from './terms';

export const methodWords: Record<string, { title: string; what: string }> = {
  nominal: { title: 'the drawing', what: 'nominal geometry; only where the robot stands or its scales read zero is fitted' },
  kinematic: { title: 'geometry identified', what: 'the robot’s own lengths, angles and offsets by nonlinear least squares' },
  classic: { title: 'classic: drawing and error model', what: 'nominal inverse geometry, and its error by the formula' },
  stepwise: { title: 'ours: stepwise regression', what: 'the formula alone; no geometry is assumed' },
};

// Which figure a method is judged by, best first; "calibration" is no rows held out.
const figures = [
  { id: 'validation', key: 'a90_validation', words: 'A90 on validation rows', of: (one: MethodOutcome_Output) => one.a90Validation },
  { id: 'together', key: 'a90_groups', words: 'A90 on rows held out together', of: (one: MethodOutcome_Output) => one.a90Groups },
  { id: 'blocks', key: 'a90_blocks', words: 'A90 on blocks of time held out', of: (one: MethodOutcome_Output) => one.a90Blocks },
  { id: 'calibration', key: 'a90_calibration', words: 'A90 on calibration rows', of: (one: MethodOutcome_Output): number | undefined => one.a90Calibration },
] as const;

// Root of the mean square over the outputs; undefined where units differ or a figure is missing.
export function overOutputs(method: MethodOutcome, of: (one: MethodOutcome_Output) => number | undefined): number | undefined {
  const values = method.outputs.map(of);
  if (values.length === 0 || values.some((value) => value === undefined) || new Set(method.outputs.map((one) => one.unit)).size > 1) return undefined;
  return Math.sqrt(values.reduce((sum: number, value) => sum + value! * value!, 0) / values.length);
}

export function MethodsResult({ answer, of, tookMs }: { answer: CompareMethodsResponse; of: string; tookMs: number }) {
  const methods = answer.methods;
  if (methods.length === 0) return <Panel><Empty next="Type a formula, or give the robot’s geometry.">No method could be fitted.</Empty></Panel>;
  const possible = figures.filter((figure) => methods.some((method) => method.outputs.some((one) => figure.of(one) !== undefined)));
  const figure = possible.find((one) => one.id === query('judged')) ?? possible[0];
  const details = methodsOf(answer.json);
  const unit = unitSign(methods[0].outputs[0]?.unit ?? '');
  const ranked = [...methods].sort((a, b) => (overOutputs(a, figure.of) ?? Infinity) - (overOutputs(b, figure.of) ?? Infinity));
  const best = overOutputs(ranked[0], figure.of) !== undefined ? ranked[0] : undefined;
  const scale = logScale(methods.flatMap((method) => method.outputs.map((one) => figure.of(one) ?? 0)));
  const symbols = methods[0].outputs.map((one) => splitChannel(one.channel).symbol);
  const warned = methods.filter((method) => method.warnings.length > 0);
  return (
    <>
      <Panel
        title={best ? 'Methods, least error first' : 'Methods'}
        actions={<><SymbolChoice symbols={possible.map((one) => one.id)} name="judged" label="Judged by" /><Button small onPress={() => download('methods.json', answer.json, 'application/json')}>JSON</Button></>}
      >
        <p class="note muted">
          <A90 /> {figure.words.slice(4)}, {unit}; bars on one logarithmic scale{possible.some((one) => one.id !== 'calibration') && figure.id === 'calibration' && '; these rows were fitted to: they flatter'}.
          {' '}<code>{of}</code>, worked out in {fixed(tookMs / 1000, 1)} s
        </p>
        <Table
          caption={`Methods by ${figure.words}`}
          rows={ranked}
          keyOf={(method) => method.method}
          columns={[
            { title: 'method', of: (method) => <Name method={method} error={overOutputs(method, figure.of)} least={best && overOutputs(best, figure.of)} /> },
            { title: 'parameters', number: true, sort: (method) => method.parameterCount, of: (method) => method.parameterCount },
            { title: `all outputs, ${unit}`, number: true, sort: (method) => overOutputs(method, figure.of) ?? Infinity, of: (method) => <strong>{significant(overOutputs(method, figure.of), 2)}</strong> },
            ...symbols.map((symbol, at) => ({
              title: `${symbol}, ${unitSign(methods[0].outputs[at].unit)}`,
              of: (method: MethodOutcome) => <Figure value={method.outputs[at] && figure.of(method.outputs[at])} scale={scale}
                interval={intervalOf(named(details, method.method), symbol, figure.key, methods[0].outputs[at].unit)} />,
            })),
            { title: 'fit, ms', number: true, sort: (method) => secondsOf(method.fitDuration) ?? 0, of: (method) => significant((secondsOf(method.fitDuration) ?? 0) * 1000, 2) },
          ]}
        />
        <p class="note muted">all outputs: root mean square over {symbols.join(', ')}{figure.key !== 'a90_validation' && figure.key !== 'a90_calibration' && '; in brackets: 90 % interval'}</p>
        {warned.length > 0 && (
          <details>
            <summary><Warned>remarks</Warned></summary>
            <ul class="models-warnings">{warned.flatMap((method) => method.warnings.map((words) => <li>{methodWords[method.method]?.title ?? method.method}: {words}</li>))}</ul>
          </details>
        )}
      </Panel>
      {details.filter((method) => method.method === 'kinematic' && method.kinematics).map((method) => <GeometryPanel key={method.method} method={method} />)}
    </>
  );
}

const capital = (text: string) => text[0].toUpperCase() + text.slice(1);
const named = (details: readonly MethodJson[], name: string) => details.find((one) => one.method === name);

// Errors that differ by less than this share are as good as equal: the held-out figures themselves are no surer.
const asGood = 0.05;

function Name({ method, error, least }: { method: MethodOutcome; error: number | undefined; least: number | undefined }) {
  const words = methodWords[method.method];
  const verdict = error === undefined || least === undefined || error > least * (1 + asGood) ? undefined : error === least ? 'least error' : 'as good within 5 %';
  return (
    <div class="models-method">
      <p><strong>{capital(words?.title ?? method.method)}</strong> {verdict && <Verdict kind="good">{verdict}</Verdict>}</p>
      {words && <p class="note muted">{words.what}</p>}
    </div>
  );
}

function Figure({ value, scale, interval }: { value: number | undefined; scale: (value: number) => number; interval: readonly [number, number] | undefined }) {
  if (value === undefined) return <span class="muted">–</span>;
  return (
    <div class="models-figure">
      <Bar share={scale(value)} {...(interval && { low: scale(interval[0]), high: scale(interval[1]) })} />
      <span class="nowrap">{significant(value, 2)}{interval && <span class="note muted"> ({significant(interval[0], 2)} to {significant(interval[1], 2)})</span>}</span>
    </div>
  );
}
