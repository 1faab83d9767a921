import { useState } from 'preact/hooks';
import { place, setQuery } from '@/app/router';
import { fixed } from '@/format/numbers';
import { Field, numberTyped } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { startOf, type PoseField } from './pose';

// Every number that can be read goes to the address at once; what cannot stays in its field with what is wrong.
export function PoseForm({ fields }: { fields: readonly PoseField[] }) {
  return (
    <Panel title="Wanted pose">
      <div class="targets-pose">{fields.map((field) => <PoseInput key={field.channel} field={field} />)}</div>
    </Panel>
  );
}

function PoseInput({ field }: { field: PoseField }) {
  const fromAddress = place.value.query.get(field.symbol) ?? String(startOf(field));
  const [text, setText] = useState(fromAddress);
  const shown = numberTyped(text) === Number(fromAddress) || numberTyped(text) === undefined ? text : fromAddress;
  const value = numberTyped(shown);
  const outside = value !== undefined && (value < field.min || value > field.max);
  const digits = field.unit === 'arcsec' ? 1 : 2;
  const range = `fitted from ${fixed(field.min, digits)} to ${fixed(field.max, digits)}`;
  return (
    <Field
      label={field.symbol}
      unit={field.unit}
      type="number"
      value={shown}
      onInput={(next) => {
        setText(next);
        const number = numberTyped(next);
        if (number !== undefined) setQuery({ [field.symbol]: String(number) });
      }}
      wrong={value === undefined ? `a number in ${field.unit} is expected` : undefined}
      hint={outside ? `outside: ${range}` : range}
    />
  );
}
