// Which output a picture speaks of; it stands in the address (?out=q2).
import type { Model, ModelOutput } from '@/api/gen/driftwise/v1/model_service_pb';
import { query, setQuery } from '@/app/router';
import { outputSymbol } from './figures';

export const useOutput = (model: Model): ModelOutput =>
  model.outputs.find((output) => outputSymbol(output) === query('out')) ?? model.outputs[0];

export function OutputChoice({ model }: { model: Model }) {
  return <SymbolChoice symbols={model.outputs.map(outputSymbol)} />;
}

export function SymbolChoice({ symbols, name = 'out', label = 'Output' }: { symbols: readonly string[]; name?: string; label?: string }) {
  const chosen = symbols.includes(query(name) ?? '') ? query(name) : symbols[0];
  if (symbols.length < 2) return null;
  return (
    <div class="choice" role="group" aria-label={label}>
      {symbols.map((symbol) => (
        <button type="button" key={symbol} aria-pressed={symbol === chosen ? 'true' : 'false'} onClick={() => setQuery({ [name]: symbol === symbols[0] ? undefined : symbol })}>{symbol}</button>
      ))}
    </div>
  );
}
