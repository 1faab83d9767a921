import { setQuery } from '@/app/router';
import { rangeText } from '@/format/numbers';
import { Field, numberTyped } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { textOf, type PoseField, type Typed } from './pose';

export const numberWanted = (field: PoseField) => `a number in ${field.unit} is expected`;

// Every number that can be read goes to the address at once; what cannot stays in its field with what is wrong.
export function PoseForm({ fields, typed, type }: { fields: readonly PoseField[]; typed: Typed; type: (symbol: string, text: string) => void }) {
  return (
    <Panel title="Wanted pose">
      <div class="targets-pose">{fields.map((field) => <PoseInput key={field.channel} field={field} typed={typed[field.symbol]} type={type} />)}</div>
    </Panel>
  );
}

function PoseInput({ field, typed, type }: { field: PoseField; typed: string | undefined; type: (symbol: string, text: string) => void }) {
  const shown = textOf(field, typed);
  const value = numberTyped(shown);
  const outside = value !== undefined && (value < field.min || value > field.max);
  const digits = field.unit === 'arcsec' ? 1 : 2;
  const range = `fitted from ${rangeText(field.min, field.max, digits)}`;
  return (
    <Field
      label={field.symbol}
      unit={field.unit}
      type="number"
      value={shown}
      onInput={(next) => {
        type(field.symbol, next);
        const number = numberTyped(next);
        if (number !== undefined) setQuery({ [field.symbol]: String(number) });
      }}
      wrong={value === undefined ? numberWanted(field) : undefined}
      hint={outside ? `outside: ${range}` : range}
    />
  );
}
