// The geometry that a kinematic identification found, against the drawing.
import { significant, signed, fixed } from '@/format/numbers';
import { splitChannel, unitSign } from '@/format/units';
import { Panel } from '@/ui/panel';
import { Table } from '@/ui/table';
import { Verdict } from '@/ui/verdict';
import type { GeometryParameter, MethodJson } from './methods_json';

// Digits that two figures of the standard error support, at most nine.
export function supportedDigits(error: number | null | undefined): number {
  return error && error > 0 && Number.isFinite(error) ? Math.min(9, Math.max(0, 1 - Math.floor(Math.log10(error)))) : 4;
}

export function GeometryPanel({ method }: { method: MethodJson }) {
  const rows = [...method.kinematics!.parameters].sort((a, b) => Number(b.free) - Number(a.free));
  const free = rows.filter((one) => one.free).length;
  const words = (one: GeometryParameter) => splitChannel(one.name);
  return (
    <Panel title="The geometry found">
      <p class="note muted">{free} of {rows.length} lengths, angles and offsets were estimated; ± one standard error, true for independent errors</p>
      <Table
        caption={`Parameters of the geometry by the method ${method.method}`}
        rows={rows}
        page={12}
        keyOf={(one) => one.name}
        rowClass={(one) => (one.free ? undefined : 'models-out')}
        columns={[
          { title: 'parameter', of: (one) => <code>{words(one).symbol}</code> },
          { title: 'unit', of: (one) => unitSign(words(one).unit) },
          { title: 'drawing', number: true, of: (one) => fixed(one.nominal, supportedDigits(one.standard_error)) },
          { title: 'found', number: true, of: (one) => (one.free ? `${fixed(one.value ?? undefined, supportedDigits(one.standard_error))} ± ${significant(one.standard_error ?? undefined, 2)}` : '') },
          { title: 'found − drawing', number: true, sort: (one) => (one.free && one.value !== null ? Math.abs((one.value - one.nominal) / (one.standard_error || 1)) : -1),
            of: (one) => (one.free && one.value !== null ? signed(one.value - one.nominal, supportedDigits(one.standard_error)) : '') },
          { title: 'state', of: (one) => (one.free ? <Verdict kind="good">estimated</Verdict> : <Verdict kind="idle">held</Verdict>) },
          { title: 'remark', of: (one) => (one.note === 'nominal' ? '' : (one.note ?? '')) },
        ]}
      />
    </Panel>
  );
}
